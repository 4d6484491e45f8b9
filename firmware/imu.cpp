// The sketch, as PlatformIO compiles it.
#include <Arduino.h>
#include "imu/imu.ino"
