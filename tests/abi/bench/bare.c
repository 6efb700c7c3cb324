/* What an FMU is measured against: the same arithmetic in a C library of its own, with no more
 * around it than the signature of fmi2DoStep. `linear` is the model of bench-fmus/src/lib.rs, `pid` one
 * tick of eq 14 as fmu/models/src/pid/mod.rs has it, limits and anti-windup included. */
#include <math.h>

static const double A[4][4] = {{0.95, 0.05, 0.0, 0.0},
                               {-0.05, 0.95, 0.02, 0.0},
                               {0.0, 0.0, 0.8, 0.1},
                               {0.0, 0.0, -0.1, 0.8}};
static const double B[4] = {0.01, 0.02, 0.03, 0.01};
static const double C[4] = {1.0, 0.5, 0.25, 0.125};

static struct { double x[4], u, y; } linear = {{0, 0, 0, 0}, 1.0, 0.0};

int linear_step(void *component, double time, double step, int flag) {
    double x[4] = {linear.x[0], linear.x[1], linear.x[2], linear.x[3]}, y = 0.0;
    (void)component, (void)time, (void)step, (void)flag;
    for (int i = 0; i < 4; i++) {
        double row = A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2] + A[i][3] * x[3];
        linear.x[i] = row + B[i] * linear.u;
        y += C[i] * linear.x[i];
    }
    linear.y = y;
    return 0;
}

static struct {
    double kp, ki, kd, tf, b, c, tt, max_angle, max_increment, max_rate, ts;
    double r, y, ff, r_before, y_before, i, d, u;
} pid = {30.0, 2.0, 1.5, 0.02, 0.7, 0.0, 0.5, 5.76, 3.9, 6.0, 0.01, 1e-3, 0, 0, 0, 0, 0, 0, 0};

static double wrap(double angle) {
    if (angle > -M_PI && angle <= M_PI) return angle;
    return angle - 2.0 * M_PI * ceil((angle - M_PI) / (2.0 * M_PI));
}

int pid_step(void *component, double time, double step, int flag) {
    double error = wrap(pid.r - pid.y), filter = 1.0 / (pid.tf + pid.ts);
    double dr = wrap(pid.r - pid.r_before), dy = wrap(pid.y - pid.y_before);
    double increment = fmin(pid.max_increment, pid.max_rate * pid.ts), v, u;
    (void)component, (void)time, (void)step, (void)flag;
    pid.d = pid.tf * filter * pid.d + pid.kd * (pid.c * dr - dy) * filter;
    pid.i += pid.ki * pid.ts * error - pid.kp * (1.0 - pid.b) * dr;
    v = pid.kp * error + pid.d + pid.ff + pid.i;
    u = fmin(fmax(v, pid.u - increment), pid.u + increment);
    u = fmin(fmax(u, -pid.max_angle), pid.max_angle);
    pid.i += fmin(pid.ts / pid.tt, 1.0) * (u - v);
    pid.r_before = pid.r;
    pid.y_before = pid.y;
    pid.u = u;
    return 0;
}
