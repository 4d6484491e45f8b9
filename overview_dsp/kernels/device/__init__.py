"""What runs in an audio device's callback, native or in a browser."""
