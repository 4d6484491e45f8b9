/* What Faust's C needs to be called: its types, the model's tables, and one function. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
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

/* inputs and outputs: a pointer to float64 [frames] for each */
void peer_run(double **inputs, double **outputs, int32_t frames) {
    mydsp *dsp = newmydsp();
    initmydsp(dsp, 48000);
    computemydsp(dsp, frames, inputs, outputs);
    deletemydsp(dsp);
}
