// The sketch, as PlatformIO compiles it.
#include <Arduino.h>
#include "pot/pot.ino"
