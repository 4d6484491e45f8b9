"""A player opened by settings: what it is opened with, and what is remembered of its device."""

from __future__ import annotations

import pytest

import overview_dsp as ov
from overview_dsp.live.output import settings as output_settings
from overview_dsp.live.output.settings import OutputSettings, resolve_output, save_settings
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import OpenedPlayer, PlayerSettings


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The file of remembered settings, which isn't there yet."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    path = tmp_path / "outputs.json"
    monkeypatch.setattr(output_settings, "settings_file", lambda: path)
    return path


def test_a_device_keeps_its_actuator_until_another_or_none_is_named(kept):
    def played(actuator, **tactor):
        resolved = resolve_output("pad", {}, tactor, actuator)
        if resolved.differ(resolved.settings):
            save_settings("pad", resolved.settings)
        return resolved.settings

    c2 = ov.load_actuator("c2")
    assert played(None).actuator is None
    assert not kept.exists()
    assert played("c2").actuator == c2
    again = played(None, gain_db=-3.0)
    assert again.actuator == c2
    assert played(None) == again
    assert played("none").actuator is None
    assert played(None).actuator is None
    assert played(None).tactor.gain_db == -3.0
    kept.write_text(kept.read_text().replace('"actuator": null', '"actuator": "gone"'))
    with pytest.raises(ov.InputError, match=r"outputs\.json: actuator of 'pad': no actuator"):
        played(None)
    with pytest.raises(ov.InputError, match=r"^no actuator is called 'gone'"):
        played("gone")
    assert played("none").actuator is None
    assert resolve_output(None, {}, {}, None).settings == OutputSettings()


def test_a_player_without_sound_shows_its_window_saves_its_take_and_remembers_nothing(
    match, kept, tmp_path
):
    take, notes, said = tmp_path / "take.csv", [], []
    settings = PlayerSettings(
        "football",
        compare="plain",
        linear=True,
        window=(600.0, 1200.0),
        device="none",
        sample_rate=16_000.0,
        click={"gain_db": -6.0},
        record=str(take),
        seed=3,
    )
    with OpenedPlayer(match, settings, notes.append, said.append) as player:
        assert player.window == (600.0, 1200.0)
        assert (player.engine.sample_rate, player.engine.seed) == (16_000.0, 3)
        assert player.output.settings.click.gain_db == -6.0
        assert player.engine.surface.angle_map.is_linear
        player.choose_preset(1)
        poll(player)
        assert player.engine.preset.name == "plain"
        player.say("once more")
    assert "once more" in notes
    assert len(said) == 1
    assert said[0].startswith(f"take saved as {take}")
    assert ov.load_gesture(take).duration_s > 0.0
    assert not kept.exists()


def test_an_invalid_window_is_refused_before_anything_is_opened(match, kept, tmp_path):
    settings = PlayerSettings(
        "football", window=(5.0, 1.0), device="none", record=str(tmp_path / "take.csv")
    )
    with pytest.raises(ov.InputError):
        OpenedPlayer(match, settings, print, print)
    assert not (tmp_path / "take.csv").exists()
