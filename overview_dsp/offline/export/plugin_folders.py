"""Where a format keeps a plugin's library and what hosts read beside it."""

from __future__ import annotations

import plistlib
from pathlib import PurePosixPath

from overview_dsp.offline.export.lv2_turtle import DESCRIPTIONS, description, manifest
from overview_dsp.offline.export.plugin_bundle import Bundle
from overview_dsp.offline.export.plugin_compiler import Machine

_LIBRARY = {"linux": ".so", "windows": ".dll", "macos": ".dylib"}


def contents_of(to: str, bundle: Bundle, machine: Machine, library: bytes) -> dict[str, bytes]:
    """The files of a plugin by their paths in the folder it is put into; the first is the plugin's.

    Of a single file or a folder; a VST3's holds a library for each system, side by side.
    """
    called = f"{bundle.slug}.{to}"
    if to == "lv2":
        name = f"plugin{_LIBRARY[machine.system]}"
        return {
            f"{called}/{name}": library,
            f"{called}/{DESCRIPTIONS}": description(bundle).encode(),
            f"{called}/manifest.ttl": manifest(name, bundle).encode(),
        }
    if machine.system == "macos":
        inside = PurePosixPath(called, "Contents")
        return {
            str(inside / "MacOS" / bundle.slug): library,
            str(inside / "Info.plist"): _property_list(bundle),
            str(inside / "PkgInfo"): b"BNDL????",
        }
    if to == "clap":
        return {called: library}
    windows = machine.system == "windows"
    inside = PurePosixPath(
        called, "Contents", f"{machine.processor}-{'win' if windows else 'linux'}"
    )
    return {str(inside / f"{bundle.slug}.{'vst3' if windows else 'so'}"): library}


def _property_list(bundle: Bundle) -> bytes:
    return plistlib.dumps(
        {
            "CFBundleDevelopmentRegion": "en",
            "CFBundleExecutable": bundle.slug,
            "CFBundleIdentifier": bundle.id,
            "CFBundleInfoDictionaryVersion": "6.0",
            "CFBundleName": bundle.name,
            "CFBundlePackageType": "BNDL",
            "CFBundleSignature": "????",
            "CFBundleVersion": "1.0.0",
        }
    )
