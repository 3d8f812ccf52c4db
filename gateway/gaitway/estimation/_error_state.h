/* The arithmetic of the error-state filter, without Python: what error_state.py says in words and
 * _kernels_twin.py in numpy, block by block.
 *
 * The transition F is the identity plus four 3x3 blocks, so it is applied as four elementary steps
 * "block += M block"; the covariance P is symmetric, so only its upper triangle is computed. Its
 * 3x3 blocks on the diagonal are kept whole, so that a block is read the same way everywhere.
 *
 * The number of states is a constant wherever these functions are inlined: one text, two programs.
 * No operation depends on how many samples come in one call.
 */
#ifndef GAITWAY_ERROR_STATE_H
#define GAITWAY_ERROR_STATE_H

#include <math.h>

#define INLINE static inline __attribute__((always_inline))

/* Where each block of three begins, in the order of error_state.py. */
enum { POS = 0, VEL = 3, ATT = 6, GYRO_BIAS = 9, ACCEL_BIAS = 12, MAX_STATES = 15 };
enum { NOMINAL = 16, Q_ND = 6, GYRO_BIAS_NOMINAL = 10, ACCEL_BIAS_NOMINAL = 13 };

typedef double Matrix3[3][3];
typedef double Rows[MAX_STATES][MAX_STATES];

typedef struct {
    double nominal[NOMINAL]; /* pos_n, vel_n, q_nd, gyro_bias_d, accel_bias_d */
    Rows P;
} Filter;

/* What every sample of a call shares; the four densities are those of ImuNoise. */
typedef struct {
    double dt_s, gravity_mps2;
    double accel_mps2_rthz, gyro_radps_rthz, accel_bias_walk_mps2_rts, gyro_bias_walk_radps_rts;
} Sampling;

/* A point of the device that stands still; zero lever arm: the sensor itself. */
typedef struct {
    double imu_to_pivot_d[3], sigma_mps;
} Pivot;

/* row[j] += x a[j] + y b[j] + z c[j] for begin <= j < end, two at a time: the inner loop of all that
 * touches the covariance, so it is not left to the compiler to find out. */
typedef double Pair __attribute__((vector_size(16), aligned(8), may_alias));

INLINE void add_rows(double *row, double x, const double *a, double y, const double *b, double z,
                     const double *c, int begin, int end)
{
    int j = begin;
    for (; j + 2 <= end; j += 2)
        *(Pair *)(row + j) += x * *(const Pair *)(a + j) + y * *(const Pair *)(b + j) +
                              z * *(const Pair *)(c + j);
    if (j < end)
        row[j] += x * a[j] + y * b[j] + z * c[j];
}

INLINE void add_row(double *row, double x, const double *a, int begin, int end)
{
    int j = begin;
    for (; j + 2 <= end; j += 2)
        *(Pair *)(row + j) += x * *(const Pair *)(a + j);
    if (j < end)
        row[j] += x * a[j];
}

INLINE void multiply(const double p[4], const double q[4], double out[4])
{
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
    out[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
    out[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
}

INLINE void normalize(const double q[4], double out[4])
{
    double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    double scale = copysign(1.0, q[0]) / sqrt(square);
    for (int i = 0; i < 4; i++)
        out[i] = scale * q[i];
}

/* Below a quarter of a radian of half the angle, six terms of the series are exact to the last
 * bits and several times faster than the library; a sample turns by less. */
INLINE void from_rotation_vector(const double v[3], double q[4])
{
    double square = 0.25 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    double cosine, sinc; /* of half the angle; sin(x)/x */
    if (square < 0.0625) {
        double s = square;
        sinc = 1 - s * (1 / 6. - s * (1 / 120. - s * (1 / 5040. - s * (1 / 362880. - s / 39916800))));
        cosine = 1 - s * (1 / 2. - s * (1 / 24. - s * (1 / 720. - s * (1 / 40320. - s * (1 / 3628800.)))));
    } else {
        double half = sqrt(square);
        cosine = cos(half);
        sinc = sin(half) / half;
    }
    q[0] = cosine;
    for (int i = 0; i < 3; i++)
        q[1 + i] = 0.5 * sinc * v[i];
}

INLINE void to_matrix(const double q[4], Matrix3 C)
{
    double w = q[0], x = q[1], y = q[2], z = q[3];
    C[0][0] = 1.0 - 2.0 * (y * y + z * z);
    C[0][1] = 2.0 * (x * y - w * z);
    C[0][2] = 2.0 * (x * z + w * y);
    C[1][0] = 2.0 * (x * y + w * z);
    C[1][1] = 1.0 - 2.0 * (x * x + z * z);
    C[1][2] = 2.0 * (y * z - w * x);
    C[2][0] = 2.0 * (x * z - w * y);
    C[2][1] = 2.0 * (y * z + w * x);
    C[2][2] = 1.0 - 2.0 * (x * x + y * y);
}

/* Integrates one sample with the attitude at its middle; returns that attitude and the change of
 * velocity that the specific force made, in n. */
INLINE void navigate(double x[NOMINAL], const double accel_d[3], const double gyro_d[3],
                     const Sampling *s, Matrix3 C, double delta_v[3])
{
    double dt = s->dt_s, half_turn[4], q_middle[4], q_end[4], half_angle[3], force_d[3];
    for (int i = 0; i < 3; i++) {
        half_angle[i] = (gyro_d[i] - x[GYRO_BIAS_NOMINAL + i]) * (0.5 * dt);
        force_d[i] = accel_d[i] - x[ACCEL_BIAS_NOMINAL + i];
    }
    from_rotation_vector(half_angle, half_turn);
    multiply(x + Q_ND, half_turn, q_middle);
    to_matrix(q_middle, C);
    for (int i = 0; i < 3; i++) {
        double force_n = C[i][0] * force_d[0] + C[i][1] * force_d[1] + C[i][2] * force_d[2];
        double accel_n = i == 2 ? force_n - s->gravity_mps2 : force_n;
        delta_v[i] = force_n * dt;
        x[POS + i] += x[VEL + i] * dt + accel_n * (0.5 * dt * dt);
        x[VEL + i] += accel_n * dt;
    }
    multiply(q_middle, half_turn, q_end);
    normalize(q_end, x + Q_ND);
}

INLINE void mirror_block(Rows P, int first)
{
    P[first + 1][first] = P[first][first + 1];
    P[first + 2][first] = P[first][first + 2];
    P[first + 2][first + 1] = P[first + 1][first + 2];
}

/* Row i of M times a vector; a skew M has nothing on its diagonal. */
INLINE double times(const Matrix3 M, int i, int skew, double x, double y, double z)
{
    if (!skew)
        return M[i][0] * x + M[i][1] * y + M[i][2] * z;
    return i == 0 ? M[0][1] * y + M[0][2] * z
         : i == 1 ? M[1][0] * x + M[1][2] * z
                  : M[2][0] * x + M[2][1] * y;
}

/* P <- E P E^T where E adds M times the block `from` of the error to the block `to` before it. */
INLINE void add_block(Rows P, int to, int from, const Matrix3 M, int skew, int states)
{
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) {
            const double *row = P[to + j] + from;
            P[to + i][to + j] += times(M, i, skew, row[0], row[1], row[2]);
        }
    for (int i = 0; i < 3; i++) {
        for (int j = to + 3; j < from; j++)
            P[to + i][j] += times(M, i, skew, P[j][from], P[j][from + 1], P[j][from + 2]);
        add_rows(P[to + i], M[i][0], P[from], M[i][1], P[from + 1], M[i][2], P[from + 2], from,
                 states);
    }
    for (int i = 0; i < to + 3; i++)
        for (int j = i < to ? 0 : i - to; j < 3; j++)
            P[i][to + j] += times(M, j, skew, P[i][from], P[i][from + 1], P[i][from + 2]);
    mirror_block(P, to);
}

/* The same where M is a number times the identity: position goes on by velocity. */
INLINE void add_velocity(Rows P, double dt, int states)
{
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            P[POS + i][POS + j] += dt * P[POS + j][VEL + i];
    for (int i = 0; i < 3; i++)
        add_row(P[POS + i], dt, P[VEL + i], VEL, states);
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            P[POS + i][POS + j] += dt * P[POS + i][VEL + j];
    mirror_block(P, POS);
}

/* What ImuNoise.process_covariance says, added. */
INLINE void add_process_noise(Rows P, const Sampling *s, int states)
{
    double dt = s->dt_s;
    double accel = s->accel_mps2_rthz * s->accel_mps2_rthz * dt;
    double gyro = s->gyro_radps_rthz * s->gyro_radps_rthz * dt;
    double gyro_walk = s->gyro_bias_walk_radps_rts * s->gyro_bias_walk_radps_rts * dt;
    double accel_walk = s->accel_bias_walk_mps2_rts * s->accel_bias_walk_mps2_rts * dt;
    for (int i = 0; i < 3; i++) {
        P[POS + i][POS + i] += accel * dt * dt / 3.0;
        P[POS + i][VEL + i] += accel * dt / 2.0;
        P[VEL + i][VEL + i] += accel;
        P[ATT + i][ATT + i] += gyro;
        if (states == 15) {
            P[GYRO_BIAS + i][GYRO_BIAS + i] += gyro_walk;
            P[ACCEL_BIAS + i][ACCEL_BIAS + i] += accel_walk;
        }
    }
}

/* One sample: nominal state and covariance. Each step of the transition reads blocks that no step
 * before it has changed, so together they are F = I + dt A of the error dynamics. */
INLINE void predict(Filter *f, const double accel_d[3], const double gyro_d[3], const Sampling *s,
                    int states)
{
    Matrix3 C, turn;
    double dv[3];
    navigate(f->nominal, accel_d, gyro_d, s, C, dv);
    Matrix3 lean = {{0.0, dv[2], -dv[1]}, {-dv[2], 0.0, dv[0]}, {dv[1], -dv[0], 0.0}};
    add_velocity(f->P, s->dt_s, states);
    add_block(f->P, VEL, ATT, (const double(*)[3])lean, 1, states);
    if (states == 15) {
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                turn[i][j] = -s->dt_s * C[i][j];
        add_block(f->P, VEL, ACCEL_BIAS, (const double(*)[3])turn, 0, states);
        add_block(f->P, ATT, GYRO_BIAS, (const double(*)[3])turn, 0, states);
    }
    add_process_noise(f->P, s, states);
}

/* A measurement on its way into the filter; its rows come by threes, zero beyond the last. */
typedef struct {
    double z[MAX_STATES];       /* measured minus predicted; whitened: L^-1 z */
    double inverse[MAX_STATES]; /* whitened: D^-1 of S = L D L^T */
    Rows S;                     /* H P H^T + R, lower triangle */
    Rows W;                     /* row k is column k of P H^T; whitened: of P H^T L^-T */
} Seen;

/* Factors S = L D L^T and takes L^-1 to the residual and to P H^T; returns whether S, as it must
 * be, is positive. What is not a number goes on as such. */
INLINE int whiten(Seen *m, int rows, int states)
{
    for (int k = 0; k < rows; k++) {
        if (m->S[k][k] <= 0.0)
            return 0;
        double inverse = m->inverse[k] = 1.0 / m->S[k][k];
        for (int i = k + 1; i < rows; i++) {
            double lower = m->S[i][k] * inverse;
            for (int j = k + 1; j <= i; j++)
                m->S[i][j] -= lower * m->S[j][k];
            m->z[i] -= lower * m->z[k];
            add_row(m->W[i], -lower, m->W[k], 0, states);
        }
    }
    return 1;
}

/* Moves the error that the measurement shows into the nominal state. */
INLINE void inject(double x[NOMINAL], const double error[MAX_STATES], int states)
{
    double turn[4], q[4];
    for (int i = 0; i < 6; i++)
        x[i] += error[i];
    from_rotation_vector(error + ATT, turn);
    multiply(turn, x + Q_ND, q);
    normalize(q, x + Q_ND);
    if (states == 15)
        for (int i = 0; i < 6; i++)
            x[GYRO_BIAS_NOMINAL + i] += error[GYRO_BIAS + i];
}

/* P <- P - W^T G W, by three rows of W, in the rows of one block of P from its diagonal on. */
INLINE void lower_block(Rows P, const double W[3][MAX_STATES], const double g[3], int first,
                        int states)
{
    for (int i = first; i < first + 3; i++)
        add_rows(P[i], -g[0] * W[0][i], W[0], -g[1] * W[1][i], W[1], -g[2] * W[2][i], W[2], first,
                 states);
    mirror_block(P, first);
}

/* P <- P - W D^-1 W^T and error = W D^-1 L^-1 z, which is Joseph's form with the optimal gain. */
INLINE void take_in(Filter *f, const Seen *m, int rows, int states)
{
    double error[MAX_STATES] = {0.0};
    for (int k = 0; k < rows; k += 3) {
        const double(*W)[MAX_STATES] = (const double(*)[MAX_STATES])m->W + k;
        const double *z = m->z + k, *g = m->inverse + k;
        add_rows(error, g[0] * z[0], W[0], g[1] * z[1], W[1], g[2] * z[2], W[2], 0, states);
        lower_block(f->P, W, g, POS, states);
        lower_block(f->P, W, g, VEL, states);
        lower_block(f->P, W, g, ATT, states);
        if (states == 15) {
            lower_block(f->P, W, g, GYRO_BIAS, states);
            lower_block(f->P, W, g, ACCEL_BIAS, states);
        }
    }
    inject(f->nominal, error, states);
}

/* Copies column c of the symmetric P. */
INLINE void column(const Rows P, int c, int states, double out[MAX_STATES])
{
    for (int i = 0; i < c; i++)
        out[i] = P[i][c];
    for (int i = c; i < states; i++)
        out[i] = P[c][i];
}

/* Adds to W = P H^T and to S = H P H^T what a block M of H, at the states from `first`, gives. */
INLINE void see_block(const Rows P, Seen *m, int first, const Matrix3 M, int states)
{
    for (int a = 0; a < 3; a++) {
        double of_state[MAX_STATES];
        column(P, first + a, states, of_state);
        for (int k = 0; k < 3; k++)
            add_row(m->W[k], M[k][a], of_state, 0, states);
    }
}

/* The point stands still (measurements.pivot_velocity); returns 0 where S is not positive. */
INLINE int stand(Filter *f, const double gyro_d[3], const Pivot *p, int states)
{
    const double *x = f->nominal, *r = p->imu_to_pivot_d;
    Seen m;
    Matrix3 C, of_turn = {{0.0}}, of_bias = {{0.0}};
    int at_sensor = r[0] == 0.0 && r[1] == 0.0 && r[2] == 0.0;
    for (int k = 0; k < 3; k++) {
        m.z[k] = -x[VEL + k];
        column((const double(*)[MAX_STATES])f->P, VEL + k, states, m.W[k]);
    }
    if (!at_sensor) {
        double w[3], t[3];
        for (int i = 0; i < 3; i++)
            w[i] = gyro_d[i] - x[GYRO_BIAS_NOMINAL + i];
        double v[3] = {w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2],
                       w[0] * r[1] - w[1] * r[0]};
        to_matrix(x + Q_ND, C);
        for (int i = 0; i < 3; i++) {
            t[i] = C[i][0] * v[0] + C[i][1] * v[1] + C[i][2] * v[2];
            m.z[i] -= t[i];
            /* C_nd [lever x] */
            of_bias[i][0] = C[i][1] * r[2] - C[i][2] * r[1];
            of_bias[i][1] = C[i][2] * r[0] - C[i][0] * r[2];
            of_bias[i][2] = C[i][0] * r[1] - C[i][1] * r[0];
        }
        Matrix3 minus_turning = {{0.0, t[2], -t[1]}, {-t[2], 0.0, t[0]}, {t[1], -t[0], 0.0}};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                of_turn[i][j] = minus_turning[i][j];
        see_block((const double(*)[MAX_STATES])f->P, &m, ATT, (const double(*)[3])of_turn, states);
        if (states == 15)
            see_block((const double(*)[MAX_STATES])f->P, &m, GYRO_BIAS, (const double(*)[3])of_bias,
                      states);
    }
    for (int k = 0; k < 3; k++)
        for (int l = 0; l <= k; l++) {
            double s = m.W[l][VEL + k];
            if (!at_sensor)
                for (int a = 0; a < 3; a++) {
                    s += of_turn[k][a] * m.W[l][ATT + a];
                    if (states == 15)
                        s += of_bias[k][a] * m.W[l][GYRO_BIAS + a];
                }
            m.S[k][l] = k == l ? s + p->sigma_mps * p->sigma_mps : s;
        }
    if (!whiten(&m, 3, states))
        return 0;
    take_in(f, &m, 3, states);
    return 1;
}

#endif
