// The sketch, as PlatformIO compiles it.
#include <Arduino.h>
#include "encoder/encoder.ino"
