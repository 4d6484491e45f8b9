/* Stand-in for the I2S driver and the tasks of an ESP32-S3. */
#define ESP_ERROR_CHECK(done) (void)(done)
#define portMAX_DELAY 0xFFFFFFFFu
#define configMAX_PRIORITIES 25
#define I2S_GPIO_UNUSED GPIO_NUM_NC

enum gpio_num_t { GPIO_NUM_NC = -1, GPIO_NUM_15 = 15, GPIO_NUM_16, GPIO_NUM_17 };
enum { I2S_NUM_AUTO, I2S_ROLE_MASTER, I2S_DATA_BIT_WIDTH_16BIT, I2S_SLOT_MODE_STEREO };
typedef struct i2s_channel *i2s_chan_handle_t;
struct i2s_chan_config_t {
  int id, role;
  uint32_t dma_desc_num, dma_frame_num;
  bool auto_clear;
};
struct i2s_std_config_t {
  struct { uint32_t sample_rate_hz; } clk_cfg;
  struct { int data_bit_width, slot_mode; } slot_cfg;
  struct { gpio_num_t mclk, bclk, ws, dout, din; } gpio_cfg;
};
#define I2S_CHANNEL_DEFAULT_CONFIG(number, role) {number, role, 6, 240, false}
#define I2S_STD_CLK_DEFAULT_CONFIG(rate) {rate}
#define I2S_STD_PHILIPS_SLOT_DEFAULT_CONFIG(bits, mode) {bits, mode}

static int i2s_new_channel(const i2s_chan_config_t *, i2s_chan_handle_t *, i2s_chan_handle_t *) { return 0; }
static int i2s_channel_init_std_mode(i2s_chan_handle_t, const i2s_std_config_t *) { return 0; }
static int i2s_channel_enable(i2s_chan_handle_t) { return 0; }
int i2s_channel_write(i2s_chan_handle_t, const void *, size_t, size_t *, uint32_t);
static void (*task)(void *);
static void xTaskCreatePinnedToCore(void (*run)(void *), const char *, int, void *, int, void *, int) { task = run; }
