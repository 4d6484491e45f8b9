/* What Faust's C needs to be called: its types, the model's tables, and one function. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif
#define FAUSTFLOAT double
#include <faust/gui/CInterface.h>
/* the vectorised builds call these */
static inline int min(int a, int b) { return a < b ? a : b; }
static inline int max(int a, int b) { return a > b ? a : b; }
#include "generated.c"

void peer_tables(const double *friction, const double *below, const double *release) {
    friction_table = friction;
    below_table = below;
    release_table = release;
}

/* inputs and outputs: a pointer to float64 [frames] for each; denormals are off, as in Faust's own
 * hosts, while it runs */
void peer_run(double **inputs, double **outputs, int32_t frames) {
#ifdef __SSE__
    unsigned int before = _mm_getcsr();
    _mm_setcsr(before | 0x8040);
#endif
    mydsp *dsp = newmydsp();
    initmydsp(dsp, 48000);
    computemydsp(dsp, frames, inputs, outputs);
    deletemydsp(dsp);
#ifdef __SSE__
    _mm_setcsr(before);
#endif
}
