/* A potentiometer turns the timeline.

Wiring   one end to GND, the other to 5V (to 3V3 on a board that runs on 3.3 V), the wiper to A0
         (ESP32: 34, ESP32-S3: 4); all boards: docs/guide/boards.md
Flash    Arduino IDE: open this folder's pot.ino, choose board and port, upload
Play     overview play MATCH --input serial:PORT
Prints on reset
         # overview pot 1: lines of pot, 0 to 1023, 200 a second
         pot
         512
*/

#if defined(CONFIG_IDF_TARGET_ESP32)
const int WIPER = 34;
#elif defined(ESP32)  // S3, C3
const int WIPER = 4;
#else
const int WIPER = A0;
#endif
const int RATE_HZ = 200;

void setup() {
  Serial.begin(115200);
#if !defined(__AVR__) && !defined(ESP8266)
  analogReadResolution(10);  // the range of the other boards
#endif
  Serial.println(F("# overview pot 1: lines of pot, 0 to 1023, 200 a second"));
}

void loop() {
  static unsigned long due = micros();
  static int line = 0;
  if ((long)(micros() - due) < 0) return;
  due += 1000000UL / RATE_HZ;
  if (line == 0) Serial.println(F("pot"));  // the column's name, once a second
  line = (line + 1) % RATE_HZ;
  Serial.println(analogRead(WIPER));
}
