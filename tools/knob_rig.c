/* The motor knob's firmware (surface.h) for tools and tests on this machine, and a rig: encoder,
winding, cogging, knob and hand, stepped RIG_TICKS times in each step of the board. */
#include "surface.h"

#include <math.h>

int board_size(void) { return (int)sizeof(Knob); }
void board_begin(Knob *k, float shaft) { knob_begin(k, shaft); }
void board_receive(Knob *k, const uint8_t *data, int count) {
    while (count--) knob_receive(k, *data++);
}
float board_step(Knob *k, float shaft) { return knob_step(k, shaft); }
int board_report(Knob *k, uint32_t now_us, uint8_t *out) { return knob_report(k, now_us, out); }
float board_disk(const Knob *k) { return k->x / (float)(KNOB_POINTS - 1); }
int board_table(const Knob *k) { return k->active_id; }

/* J, of the pull with the shaft at `shaft` (rad); nothing else is returned to the hand */
double board_stored(const Knob *k, double shaft) {
    double end = KNOB_POINTS - 1, joule = 0.5 / KNOB_PER_RAD / fabs(k->disk.per_rad);
    double u = (shaft - k->origin) * k->disk.per_rad * KNOB_PER_RAD, home = k->home_level * k->home;
    double inside = u < 0.0 ? 0.0 : u > end ? end : u, beyond = fabs(u - inside);
    double most = KNOB_PULL * k->disk.ceiling - (u > 0.0 ? home * inside : 0.0);
    double bent = most / k->end;
    if (k->level <= 0.0f) return 0.0;
    beyond = beyond < bent ? beyond * beyond : bent * (2.0 * beyond - bent);
    if (u > end) home *= inside * (2.0 * u - inside);
    else home *= inside * inside;
    return joule * (home + k->end * beyond);
}

enum { RIG_TICKS = 32000 / KNOB_HZ, RIG_LATEST = 64 };

typedef struct {
    double inertia, friction, damping;    /* of the knob, with the fingers */
    double stiffness, hand_damping;       /* of the hand, towards its target */
    double step, noise, late_s;           /* of the encoder: rad, standard deviation in rad, s */
    double winding_s, cogging, cogs;      /* s, N m, a turn */
    double angle, speed, applied, given;  /* the state: rad, rad/s, N m, J */
    double target, latest[RIG_LATEST];
    uint32_t ticks, dice;
} Rig;

static double rig_noise(Rig *r) { /* about normal */
    double sum = -6.0;
    int n;
    for (n = 0; n < 12; n++) {
        r->dice = r->dice * 1664525u + 1013904223u;
        sum += r->dice / 4294967296.0;
    }
    return sum;
}

static double rig_seen(Rig *r) {
    const int late = (int)(r->late_s * KNOB_HZ * RIG_TICKS + 0.5);
    const double angle = r->latest[(r->ticks - late) % RIG_LATEST] + r->noise * rig_noise(r);
    return (floor(angle / r->step) + 0.5) * r->step;
}

/* Run `count` steps of the board. `targets`: of the hand after each, rad; a NaN is no touch. Each row
of `rows` gets the knob's angle, the disk, the motor's torque, the hand's, the energy that the motor
gave, that its pull stores (N m, J), and 1 at the start of a knock. */
void rig_run(Knob *k, Rig *r, const double *targets, int count, double (*rows)[7]) {
    static const uint8_t ALIVE[] = {KNOB_ALIVE, 1};
    const double dt = 1.0 / (KNOB_HZ * RIG_TICKS);
    int n, tick;
    for (n = 0; n < count; n++) {
        double torque, felt = 0.0, *row = rows[n], slope = (targets[n] - r->target) / RIG_TICKS;
        float push = k->push, knocking = k->knocking;
        if (n % (KNOB_HZ / 500) == 0) knob_take(k, ALIVE, 2);
        torque = knob_step(k, (float)rig_seen(r));
        for (tick = 0; tick < RIG_TICKS; tick++) {
            double hand = 0.0, pulled, speed, stop = dt * r->friction / r->inertia, turned;
            r->target += slope;
            if (r->target == r->target)
                hand = r->stiffness * (r->target - r->angle) + r->hand_damping * (slope / dt - r->speed);
            r->applied += (torque - r->applied) * (r->winding_s > 0.0 ? dt / (r->winding_s + dt) : 1.0);
            pulled = r->applied + r->cogging * sin(r->cogs * r->angle) + hand - r->damping * r->speed;
            speed = r->speed + dt * pulled / r->inertia;
            speed = fabs(speed) > stop ? speed - copysign(stop, speed) : 0.0;
            turned = 0.5 * dt * (speed + r->speed);
            r->given += r->applied * turned;
            r->speed = speed;
            r->angle += turned;
            r->latest[++r->ticks % RIG_LATEST] = r->angle;
            felt += hand / RIG_TICKS;
        }
        r->target = targets[n];
        row[0] = r->angle;
        row[1] = k->x / (KNOB_POINTS - 1);
        row[2] = r->applied;
        row[3] = felt;
        row[4] = r->given;
        row[5] = board_stored(k, r->angle);
        row[6] = k->push > 0.0f && (push <= 0.0f || k->knocking < knocking);
    }
}
