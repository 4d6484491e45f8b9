/* A rotary encoder turns the timeline: 40 counts for the whole of it, or the number in the sensor's
file ([encoder] counts; `overview sensor setup` measures it).

Wiring   common to GND, A and B to the pins below (Uno, Nano, Pico, Teensy: 2 and 3; ESP32: 18 and
         19; ESP32-S3: 4 and 5), no resistors; all boards: docs/guide/boards.md
Flash    Arduino IDE: open this folder's encoder.ino, choose board and port, upload
Play     overview play MATCH --input serial:PORT
Prints on reset
         # overview encoder 1: lines of count, 200 a second
         count
         0
*/

#if defined(CONFIG_IDF_TARGET_ESP32)  // 2 and 3 start the chip and its serial port; 6 to 11 are its flash
const int A = 18, B = 19;
#elif defined(ESP32)  // S3, C3
const int A = 4, B = 5;
#elif defined(ESP8266)
const int A = 14, B = 12;  // D5, D6
#else
const int A = 2, B = 3;  // an Uno's pins with interrupts
#endif
const int RATE_HZ = 200;

volatile long count = 0;

#if defined(ESP32) || defined(ESP8266)
void IRAM_ATTR moved() {
#else
void moved() {
#endif
  // from the states before and now: a step forward, back, or none (if both changed, one was missed)
  static const signed char STEPS[16] = {0, 1, -1, 0, -1, 0, 0, 1, 1, 0, 0, -1, 0, -1, 1, 0};
  static unsigned char states = 3;
  states = ((states << 2) | (digitalRead(A) ? 1 : 0) | (digitalRead(B) ? 2 : 0)) & 15;
  count += STEPS[states];
}

void setup() {
  Serial.begin(115200);
  pinMode(A, INPUT_PULLUP);
  pinMode(B, INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(A), moved, CHANGE);
  attachInterrupt(digitalPinToInterrupt(B), moved, CHANGE);
  Serial.println(F("# overview encoder 1: lines of count, 200 a second"));
}

void loop() {
  static unsigned long due = micros();
  static int line = 0;
  if ((long)(micros() - due) < 0) return;
  due += 1000000UL / RATE_HZ;
  if (line == 0) Serial.println(F("count"));  // the column's name, once a second
  line = (line + 1) % RATE_HZ;
  noInterrupts();
  long now = count;
  interrupts();
  Serial.println(now);
}
