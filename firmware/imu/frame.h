// A checked frame of 24 bytes: COBS of the sample, CRC-16/X-25 of that, and a zero (docs/guide/sensors.md).

#pragma once

#include <Arduino.h>

inline uint16_t crc16(const uint8_t *data, int count) {  // "123456789" gives 0x906E
  uint16_t crc = 0xFFFF;
  while (count--) {
    crc ^= *data++;
    for (int i = 0; i < 8; i++) crc = crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1;
  }
  return crc ^ 0xFFFF;
}

inline void sendFrame(uint32_t now_us, const int16_t values[6]) {
  static uint16_t sequence = 0;
  uint8_t payload[19] = {2, (uint8_t)sequence, (uint8_t)(sequence >> 8), (uint8_t)now_us,
                         (uint8_t)(now_us >> 8), (uint8_t)(now_us >> 16), (uint8_t)(now_us >> 24)};
  memcpy(payload + 7, values, 12);  // a little-endian board
  sequence++;
  uint8_t out[24];
  int code = 0, at = 1;
  for (int i = 0; i < 19; i++) {
    if (payload[i]) {
      out[at++] = payload[i];
    } else {
      out[code] = at - code;
      code = at++;
    }
  }
  out[code] = at - code;
  uint16_t crc = crc16(out, 20);
  out[20] = 0x80 | (crc & 0x7F);
  out[21] = 0x80 | (crc >> 7 & 0x7F);
  out[22] = 0x80 | crc >> 14;
  out[23] = 0;
  Serial.write(out, 24);
}
