/* A timeline on a Teensy 4.0 or 4.1, without a computer: sound on the left channel, vibration on the
right one. README.txt of the folder above has parts and wiring; timeline.h the events.

Wiring   amplifiers (two MAX98357A): BCLK to 21, LRC to 20, DIN to 7; VIN to 5V (VIN), GND
         potentiometer: ends to GND and 3.3V, wiper to A0 (14)
         motor knob (MOTOR): driver to 9, 5, 6 (phases) and 8 (enable); encoder to 18 (SDA), 19 (SCL)
Flash    Arduino IDE with Teensyduino: open teensy4.ino, board Teensy 4.0 or 4.1, upload
Latency  two blocks of 128 samples: 5.8 ms */

// #define MOTOR  // a motor knob with the library SimpleFOC instead of a potentiometer

const int WIPER_PIN = A0, WIPER_LOW = 40, WIPER_HIGH = 4055;  // readings at the two ends, of 4095
const int TOUCH_PIN = -1;  // pulled to GND while the knob is held; -1: it always is
const int PHASE_A = 9, PHASE_B = 5, PHASE_C = 6, ENABLE = 8, POLE_PAIRS = 7;
const float SUPPLY_V = 12, LIMIT_V = 6;  // of the motor
const float NM_PER_V = 0.003;            // 8.27 / KV / phase resistance
const float CLICK_GAIN = 1, TACTOR_GAIN = 1;  // at most 1

#define KNOB_HZ 4000
#include <Audio.h>

#ifdef MOTOR
#include "surface.h"
#include "timing.h"
#endif
#include "overview_board.h"
#include "timeline.h"
#include "hand.h"

static OverviewBoard board;

class Voice : public AudioStream {
 public:
  Voice() : AudioStream(0, NULL) { overview_board_init(&board, &OVERVIEW_TIMELINE); }
  void update() override {
    static float click[AUDIO_BLOCK_SAMPLES], tactor[AUDIO_BLOCK_SAMPLES];
    overview_board_set(&board, hand_theta2, hand_touches);
    overview_board_process(&board, click, tactor, AUDIO_BLOCK_SAMPLES);
    send(click, CLICK_GAIN, 0);
    send(tactor, TACTOR_GAIN, 1);
  }

 private:
  void send(const float *samples, float gain, int channel) {
    audio_block_t *block = allocate();
    if (!block) return;
    for (int n = 0; n < AUDIO_BLOCK_SAMPLES; n++) block->data[n] = (int16_t)(32767 * gain * samples[n]);
    transmit(block, channel);
    release(block);
  }
};

static Voice voice;
static AudioOutputI2S output;
static AudioConnection left(voice, 0, output, 0), right(voice, 1, output, 1);

void setup() {
  hand_begin();
  AudioMemory(8);  // without blocks, update() sends nothing
}

void loop() { hand_read(); }
