"""Stages that run in the callback of an audio device, native or in a browser."""
