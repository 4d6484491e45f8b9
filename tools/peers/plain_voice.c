/* The same model as a textbook has it, in C with libm: the disk in radians and seconds, one loop;
 * sin, exp, pow, tanh and sqrt where the formulas have them. What one would write first; not the
 * kernels' bits.
 *
 *     gcc -O3 -march=native -shared -fPIC plain_voice.c -o plain_voice.so -lm
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { CELLS = 65536, MODES = 64 };
static const double PI = 3.141592653589793;

typedef struct {
    double dt, inertia, k1, k2, smoothing; /* s, kg m2, N m/rad, 1/sample */
    double full_torque, gate, compression, decay, rise, carrier_hz, tactor_gain;
    double strike_torque, strike_compression, approach_s, click_gain;
    double texture_gain, brightness_hz, grain_s, ceiling, dc_pole;
} Settings;

/* modes of a kind follow each other: first[kind] to first[kind + 1] */
typedef struct {
    const double *friction; /* [CELLS + 1] */
    int64_t events;
    const double *place, *release; /* rad, N m s/rad */
    const int64_t *kind, *first;
    const double *frequency_hz, *decay_s, *gain;
} Scene;

/* theta2 and touching of each sample; out float32 [frames * 2]: click, tactor */
void plain_voice(const Settings *s, const Scene *scene, const double *hand, const uint8_t *touching,
                 float *out, int64_t frames) {
    double theta = 0.0, omega = 0.0, y1 = 0.0, y2 = 0.0, approach = 0.0, follower = 0.0;
    double e1 = 0.0, e2 = 0.0, level = 0.0, grain = 0.0, phase = 0.0;
    double tactor_in = 0.0, tactor_out = 0.0, click_in = 0.0, click_out = 0.0;
    double re[MODES] = {0}, im[MODES] = {0};
    int64_t next = 0;
    const double dt = s->dt, scale = (s->k1 + s->k2) / s->k2;
    int64_t kinds = 0;
    while (scene->first[kinds + 1] > scene->first[kinds]) kinds++;
    double turn_c[MODES], turn_s[MODES];
    for (int64_t j = 0; j < scene->first[kinds]; j++) {
        double r = exp(-log(1000.0) * dt / scene->decay_s[j]);
        turn_c[j] = r * cos(2.0 * PI * scene->frequency_hz[j] * dt);
        turn_s[j] = r * sin(2.0 * PI * scene->frequency_hz[j] * dt);
    }
    int64_t ringing[MODES] = {0};
    for (int64_t n = 0; n < frames; n++) {
        if (touching[n] && (n == 0 || !touching[n - 1])) y1 = y2 = hand[n];
        y1 += s->smoothing * (hand[n] - y1);
        y2 += s->smoothing * (y1 - y2);
        /* implicit midpoint, friction at the predicted midpoint */
        double phi = (theta + 0.5 * dt * omega) * scale;
        double cell = fmin(fmax(phi / PI, 0.0), 1.0) * CELLS;
        int64_t i = (int64_t)cell;
        if (i > CELLS - 1) i = CELLS - 1;
        double b = scene->friction[i] + (cell - i) * (scene->friction[i + 1] - scene->friction[i]);
        double k = s->k1 + (touching[n] ? s->k2 : 0.0);
        double drive = touching[n] ? s->k2 * y2 : 0.0;
        double mean = (2.0 * s->inertia * omega + dt * (drive - k * theta)) /
                      (2.0 * s->inertia + dt * b + 0.5 * dt * dt * k);
        double was = theta * scale;
        theta += dt * mean;
        omega = 2.0 * mean - omega;
        double torque = b * mean, now = theta * scale;
        approach = fmax(fabs(mean), approach * exp(-dt / s->approach_s));
        /* events passed strike their modes */
        while ((next < scene->events && now >= scene->place[next]) ||
               (next > 0 && now < scene->place[next - 1])) {
            int64_t event = now >= was ? next++ : --next;
            double hard = pow(scene->release[event] * approach / s->strike_torque,
                              s->strike_compression);
            int64_t kind = scene->kind[event];
            for (int64_t j = scene->first[kind]; j < scene->first[kind + 1]; j++)
                re[j] += hard / (1.0 + hard) * scene->gain[j];
            ringing[kind] = 1;
        }
        double clicks = 0.0;
        for (int64_t kind = 0; kind < kinds; kind++) {
            if (!ringing[kind]) continue;
            double energy = 0.0;
            for (int64_t j = scene->first[kind]; j < scene->first[kind + 1]; j++) {
                clicks += im[j];
                double turned = turn_c[j] * re[j] - turn_s[j] * im[j];
                im[j] = turn_s[j] * re[j] + turn_c[j] * im[j];
                re[j] = turned;
                energy += re[j] * re[j] + im[j] * im[j];
            }
            if (energy < 1e-16) ringing[kind] = 0;
        }
        /* grain */
        level += (1.0 - exp(-dt / s->grain_s)) *
                 (s->texture_gain * sqrt(fabs(torque * mean)) - level);
        double noise = 2.0 * rand() / RAND_MAX - 1.0;
        double bright = 2.0 * PI * s->brightness_hz * dt * (fabs(mean) + 0.05);
        grain += bright / (1.0 + bright) * (level * noise - grain);
        clicks = (clicks + grain) * s->click_gain;
        /* envelope and carrier */
        double felt = fabs(torque) / s->full_torque - s->gate;
        double amplitude = felt > 0.0 ? tanh(pow(felt, s->compression)) : 0.0;
        follower = fmax(amplitude, follower + s->decay * (amplitude - follower));
        e1 += s->rise * (follower - e1);
        e2 += s->rise * (e1 - e2);
        phase = fmod(phase + s->carrier_hz * dt, 1.0);
        double wave = e2 * s->tactor_gain * sin(2.0 * PI * phase);
        tactor_out = wave - tactor_in + s->dc_pole * tactor_out;
        tactor_in = wave;
        click_out = clicks - click_in + s->dc_pole * click_out;
        click_in = clicks;
        for (int channel = 0; channel < 2; channel++) {
            double y = channel ? tactor_out : click_out, knee = 0.5 * s->ceiling;
            if (fabs(y) > knee)
                y = copysign(knee + knee * tanh((fabs(y) - knee) / knee), y);
            out[2 * n + channel] = (float)y;
        }
    }
}

/* The two disks alone: the torque of each sample of a held disk. */
void plain_disk(const Settings *s, const double *friction, const double *hand, double *torque,
                int64_t frames) {
    double theta = 0.0, omega = 0.0;
    const double dt = s->dt, scale = (s->k1 + s->k2) / s->k2, k = s->k1 + s->k2;
    for (int64_t n = 0; n < frames; n++) {
        double phi = (theta + 0.5 * dt * omega) * scale;
        double cell = fmin(fmax(phi / PI, 0.0), 1.0) * CELLS;
        int64_t i = (int64_t)cell;
        if (i > CELLS - 1) i = CELLS - 1;
        double b = friction[i] + (cell - i) * (friction[i + 1] - friction[i]);
        double mean = (2.0 * s->inertia * omega + dt * (s->k2 * hand[n] - k * theta)) /
                      (2.0 * s->inertia + dt * b + 0.5 * dt * dt * k);
        theta += dt * mean;
        omega = 2.0 * mean - omega;
        torque[n] = b * mean;
    }
}
