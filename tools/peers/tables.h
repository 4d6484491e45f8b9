/* The surface for voice.dsp, by the angle phi (rad): what the host gives it, float64 [CELLS + 1]. */
#ifndef TABLES_H
#define TABLES_H
static const double *friction_table, *below_table, *release_table;

static inline double cell_of(double phi) {
    double cell = phi * (65536.0 / 3.141592653589793);
    cell = cell > 0.0 ? cell : 0.0;
    return cell < 65535.999999 ? cell : 65535.999999;
}

static inline double friction_at(double phi) {
    double cell = cell_of(phi);
    int i = (int)cell;
    return friction_table[i] + (cell - i) * (friction_table[i + 1] - friction_table[i]);
}

static inline double events_below(double phi) { return below_table[(int)cell_of(phi)]; }
static inline double release_at(double phi) { return release_table[(int)cell_of(phi)]; }
#endif
