/* Stand-in for Teensy's audio library. */
#define AUDIO_BLOCK_SAMPLES 128
#define AudioMemory(count) ((void)0)

struct audio_block_t {
  int16_t data[AUDIO_BLOCK_SAMPLES];
};
static audio_block_t block_of_test;
static int16_t latest[2][AUDIO_BLOCK_SAMPLES];

class AudioStream {
 public:
  AudioStream(unsigned char, audio_block_t **) {}

 protected:
  static audio_block_t *allocate() { return &block_of_test; }
  static void release(audio_block_t *) {}
  void transmit(audio_block_t *block, unsigned char channel = 0) {
    for (int n = 0; n < AUDIO_BLOCK_SAMPLES; n++) latest[channel][n] = block->data[n];
  }

 private:
  virtual void update() = 0;
};
struct AudioOutputI2S : AudioStream {
  AudioOutputI2S() : AudioStream(0, NULL) {}
  void update() {}
};
struct AudioConnection {
  AudioConnection(AudioStream &, int, AudioStream &, int) {}
};
