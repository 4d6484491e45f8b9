/* Stand-in for the cores of Teensy 4 and ESP32-S3: what the sketches of a board alone use. A time
passes with each call of micros(), in which the potentiometer turns from one end to the other. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { INPUT_PULLUP = 2, LOW = 0, A0 = 14 };

static uint32_t now_us = 0xFFF00000u; /* the counter turns over soon */
static const uint32_t BEGAN_US = 0xFFF00000u;
static int wiper_pin = -1;

static uint32_t micros() { return now_us += 100; }
static void pinMode(int, int) {}
static int digitalRead(int) { return 1; }
static void analogReadResolution(int bits) {
  if (bits != 12) printf("resolution %d\n", bits);
}
static int analogRead(int pin) {
  wiper_pin = pin;
  const double part = (now_us - BEGAN_US) / 4e6;
  return (int)(4095 * (part > 1 ? 1 : part));
}
