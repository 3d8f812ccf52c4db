/* The error-state filter as a plain C program would run it: the arithmetic of the kernels over a
 * whole recording in one loop, with no Python, no buffers to open and no arguments to check. */
#include "_error_state.h"

INLINE void loop(double *nominal, double *covariance, const double *accel_d, const double *gyro_d,
                 const char *still, long n, double dt_s, double gravity_mps2,
                 const double *densities, double sigma_mps, int states)
{
    Filter f;
    Sampling s = {dt_s, gravity_mps2, densities[0], densities[1], densities[2], densities[3]};
    Pivot p = {{0.0, 0.0, 0.0}, sigma_mps};
    for (int i = 0; i < NOMINAL; i++)
        f.nominal[i] = nominal[i];
    for (int i = 0; i < states; i++)
        for (int j = 0; j < states; j++)
            f.P[i][j] = covariance[i * states + j];
    for (long row = 0; row < n; row++) {
        predict(&f, accel_d + 3 * row, gyro_d + 3 * row, &s, states);
        if (still[row])
            stand(&f, gyro_d + 3 * row, &p, states);
    }
    for (int i = 0; i < NOMINAL; i++)
        nominal[i] = f.nominal[i];
    for (int i = 0; i < states; i++)
        for (int j = i; j < states; j++)
            covariance[i * states + j] = covariance[j * states + i] = f.P[i][j];
}

void loop_9(double *nominal, double *covariance, const double *accel_d, const double *gyro_d,
            const char *still, long n, double dt_s, double gravity_mps2, const double *densities,
            double sigma_mps)
{
    loop(nominal, covariance, accel_d, gyro_d, still, n, dt_s, gravity_mps2, densities, sigma_mps,
         9);
}

void loop_15(double *nominal, double *covariance, const double *accel_d, const double *gyro_d,
             const char *still, long n, double dt_s, double gravity_mps2, const double *densities,
             double sigma_mps)
{
    loop(nominal, covariance, accel_d, gyro_d, still, n, dt_s, gravity_mps2, densities, sigma_mps,
         15);
}
