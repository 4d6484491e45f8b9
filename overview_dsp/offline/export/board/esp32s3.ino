/* A timeline on an ESP32-S3, without a computer: sound on the left channel, vibration on the right
one. README.txt of the folder above has parts and wiring; timeline.h the events.

Wiring   amplifiers (two MAX98357A): BCLK to 15, LRC to 16, DIN to 17; VIN to 5V, GND
         potentiometer: ends to GND and 3V3, wiper to 4
         motor knob (MOTOR): driver to 4, 5, 6 (phases) and 7 (enable); encoder to 8 (SDA), 9 (SCL)
Flash    Arduino IDE with the core esp32 3.0 or later: open esp32s3.ino, board ESP32S3 Dev Module,
         upload
Latency  four buffers of 64 samples: 5.8 ms */

// #define MOTOR  // a motor knob with the library SimpleFOC instead of a potentiometer

const int WIPER_PIN = 4, WIPER_LOW = 40, WIPER_HIGH = 4000;  // readings at the two ends, of 4095
const int TOUCH_PIN = -1;  // pulled to GND while the knob is held; -1: it always is
const int PHASE_A = 4, PHASE_B = 5, PHASE_C = 6, ENABLE = 7, POLE_PAIRS = 7;
const float SUPPLY_V = 12, LIMIT_V = 6;  // of the motor
const float NM_PER_V = 0.003;            // 8.27 / KV / phase resistance
const float CLICK_GAIN = 1, TACTOR_GAIN = 1;  // at most 1
#define I2S_BCLK GPIO_NUM_15
#define I2S_LRC GPIO_NUM_16
#define I2S_DIN GPIO_NUM_17

#define KNOB_HZ 4000
#include <driver/i2s_std.h>

#ifdef MOTOR
#include "surface.h"
#include "timing.h"
#endif
#include "overview_board.h"
#include "timeline.h"
#include "hand.h"

static const int FRAMES = 64;
static OverviewBoard board;
static i2s_chan_handle_t output;

static void begin_output() {
  i2s_chan_config_t channel = I2S_CHANNEL_DEFAULT_CONFIG(I2S_NUM_AUTO, I2S_ROLE_MASTER);
  channel.dma_desc_num = 4;
  channel.dma_frame_num = FRAMES;
  channel.auto_clear = true;  // silence, and no repetition, if the voice is ever late
  ESP_ERROR_CHECK(i2s_new_channel(&channel, &output, NULL));
  i2s_std_config_t format = {};
  format.clk_cfg = I2S_STD_CLK_DEFAULT_CONFIG(OVERVIEW_SAMPLE_RATE);
  format.slot_cfg = I2S_STD_PHILIPS_SLOT_DEFAULT_CONFIG(I2S_DATA_BIT_WIDTH_16BIT, I2S_SLOT_MODE_STEREO);
  format.gpio_cfg.mclk = I2S_GPIO_UNUSED;
  format.gpio_cfg.bclk = I2S_BCLK;
  format.gpio_cfg.ws = I2S_LRC;
  format.gpio_cfg.dout = I2S_DIN;
  format.gpio_cfg.din = I2S_GPIO_UNUSED;
  ESP_ERROR_CHECK(i2s_channel_init_std_mode(output, &format));
  ESP_ERROR_CHECK(i2s_channel_enable(output));
}

/* On core 0, as loop() is on core 1. Writing waits for the amplifiers and so sets the pace. */
static void play(void *) {
  static float click[FRAMES], tactor[FRAMES];
  static int16_t samples[2 * FRAMES];
  for (;;) {
    overview_board_set(&board, hand_theta2, hand_touches);
    overview_board_process(&board, click, tactor, FRAMES);
    for (int n = 0; n < FRAMES; n++) {
      samples[2 * n] = (int16_t)(32767 * CLICK_GAIN * click[n]);
      samples[2 * n + 1] = (int16_t)(32767 * TACTOR_GAIN * tactor[n]);
    }
    size_t written;
    i2s_channel_write(output, samples, sizeof samples, &written, portMAX_DELAY);
  }
}

void setup() {
  overview_board_init(&board, &OVERVIEW_TIMELINE);
  hand_begin();
  begin_output();
  xTaskCreatePinnedToCore(play, "voice", 8192, NULL, configMAX_PRIORITIES - 2, NULL, 0);
}

void loop() { hand_read(); }
