/* The compiled kernels of gaitway.estimation: checks every argument, then the arithmetic of
 * _error_state.h over a copy of the filter, then the copy back. What fails changes nothing.
 *
 * _kernels.pyi says what each function takes; _kernels_twin.py is the same in numpy.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <string.h>

#include "_error_state.h"

/* An array of another object, of one or two dimensions, any strides. */
typedef struct {
    Py_buffer buffer;
    Py_ssize_t rows, columns, row_stride, column_stride;
} Array;

static inline double at(const Array *a, Py_ssize_t i, Py_ssize_t j)
{
    double value;
    memcpy(&value, (const char *)a->buffer.buf + i * a->row_stride + j * a->column_stride,
           sizeof value);
    return value;
}

static inline void put(const Array *a, Py_ssize_t i, Py_ssize_t j, double value)
{
    memcpy((char *)a->buffer.buf + i * a->row_stride + j * a->column_stride, &value, sizeof value);
}

/* Rows of a matrix are in one piece, as a rule. */
static inline void get_row(const Array *a, Py_ssize_t i, double *row, int columns)
{
    if (a->column_stride == sizeof *row)
        memcpy(row, (const char *)a->buffer.buf + i * a->row_stride, columns * sizeof *row);
    else
        for (int j = 0; j < columns; j++)
            row[j] = at(a, i, j);
}

static inline void put_row(const Array *a, Py_ssize_t i, const double *row, int columns)
{
    if (a->column_stride == sizeof *row)
        memcpy((char *)a->buffer.buf + i * a->row_stride, row, columns * sizeof *row);
    else
        for (int j = 0; j < columns; j++)
            put(a, i, j, row[j]);
}

enum { READ = PyBUF_STRIDES | PyBUF_FORMAT, WRITE = READ | PyBUF_WRITABLE };

/* Opens an array of one type ("d" float64, "?" bool); one dimension is one column. Rows or columns
 * of -1 may be any number. Close it even when this fails, which sets an error and returns -1. */
static int open_array(PyObject *object, Array *a, int flags, const char *name, const char *format,
                      int dimensions, Py_ssize_t rows, Py_ssize_t columns)
{
    const char *type = *format == 'd' ? "float64" : "bool";
    memset(a, 0, sizeof *a);
    if (PyObject_GetBuffer(object, &a->buffer, flags) < 0) {
        PyErr_Clear();
        PyErr_Format(PyExc_TypeError, "%s: needs %s array of %s, got %.100s", name,
                     flags == WRITE ? "a writable" : "an", type, Py_TYPE(object)->tp_name);
        return -1;
    }
    const Py_buffer *b = &a->buffer;
    if (b->format == NULL || strcmp(b->format, format) != 0) {
        PyErr_Format(PyExc_TypeError, "%s: needs an array of %s, got one of format '%.20s'", name,
                     type, b->format ? b->format : "B");
        return -1;
    }
    if (b->ndim != dimensions) {
        PyErr_Format(PyExc_ValueError, "%s: needs %d dimension%s, got %d", name, dimensions,
                     dimensions == 1 ? "" : "s", b->ndim);
        return -1;
    }
    a->rows = b->shape[0];
    a->row_stride = b->strides[0];
    a->columns = dimensions == 2 ? b->shape[1] : 1;
    a->column_stride = dimensions == 2 ? b->strides[1] : 0;
    if ((rows >= 0 && a->rows != rows) || (columns >= 0 && a->columns != columns)) {
        PyErr_Format(PyExc_ValueError, "%s: has the wrong shape, %zd by %zd", name, a->rows,
                     a->columns);
        return -1;
    }
    return 0;
}

static void close_array(Array *a)
{
    if (a->buffer.obj != NULL)
        PyBuffer_Release(&a->buffer);
}

/* Reads any iterable of three numbers. */
static int read_vector(PyObject *object, const char *name, double out[3])
{
    PyObject *items = PySequence_Fast(object, "a vector is an iterable of three numbers");
    if (items == NULL)
        return -1;
    if (PySequence_Fast_GET_SIZE(items) != 3) {
        PyErr_Format(PyExc_ValueError, "%s: needs 3 numbers, got %zd", name,
                     PySequence_Fast_GET_SIZE(items));
        Py_DECREF(items);
        return -1;
    }
    for (int i = 0; i < 3; i++) {
        /* A number may be any object, and asking for its value may shorten the list it is in. */
        PyObject *number = PySequence_GetItem(items, i);
        out[i] = number == NULL ? -1.0 : PyFloat_AsDouble(number);
        Py_XDECREF(number);
        if (out[i] == -1.0 && PyErr_Occurred()) {
            Py_DECREF(items);
            return -1;
        }
    }
    Py_DECREF(items);
    return 0;
}

static int read_numbers(PyObject *const *objects, int count, double *out)
{
    for (int i = 0; i < count; i++) {
        out[i] = PyFloat_AsDouble(objects[i]);
        if (out[i] == -1.0 && PyErr_Occurred())
            return -1;
    }
    return 0;
}

/* The filter's two buffers and a copy of what is in them. */
typedef struct {
    Array nominal, covariance;
    int states;
    Filter filter;
} Opened;

static int open_filter(PyObject *const *args, Opened *o)
{
    memset(&o->covariance, 0, sizeof o->covariance);
    if (open_array(args[0], &o->nominal, WRITE, "nominal", "d", 1, NOMINAL, 1) < 0 ||
        open_array(args[1], &o->covariance, WRITE, "covariance", "d", 2, -1, -1) < 0)
        return -1;
    Py_ssize_t n = o->covariance.rows;
    if ((n != 9 && n != 15) || o->covariance.columns != n) {
        PyErr_Format(PyExc_ValueError, "covariance: is 9 by 9 or 15 by 15, not %zd by %zd", n,
                     o->covariance.columns);
        return -1;
    }
    o->states = (int)n;
    return 0;
}

/* Fills the copy, once nothing can run Python code any more. Below its diagonal blocks P is never
 * read. */
static void fetch(Opened *o)
{
    for (int i = 0; i < NOMINAL; i++)
        o->filter.nominal[i] = at(&o->nominal, i, 0);
    for (int i = 0; i < o->states; i++)
        get_row(&o->covariance, i, o->filter.P[i], o->states);
    for (int block = 0; block < o->states; block += 3)
        mirror_block(o->filter.P, block);
}

static void store(Opened *o)
{
    for (int i = 0; i < NOMINAL; i++)
        put(&o->nominal, i, 0, o->filter.nominal[i]);
    for (int i = 0; i < o->states; i++) {
        for (int j = 0; j < i; j++)
            o->filter.P[i][j] = o->filter.P[j][i];
        put_row(&o->covariance, i, o->filter.P[i], o->states);
    }
}

static void close_filter(Opened *o)
{
    close_array(&o->nominal);
    close_array(&o->covariance);
}

static void not_positive(void)
{
    PyErr_SetString(PyExc_ValueError, "the covariance of the innovation is not positive definite: "
                                      "a measurement needs noise");
}

static int wrong_count(const char *name, Py_ssize_t given, Py_ssize_t needed)
{
    if (given != needed)
        PyErr_Format(PyExc_TypeError, "%s: takes %zd arguments, got %zd", name, needed, given);
    return given != needed;
}

/* One place where the filter goes on by a sample, whoever calls: the same bits for any batch. */
static void predict_9(Filter *f, const double *accel_d, const double *gyro_d, const Sampling *s)
{
    predict(f, accel_d, gyro_d, s, 9);
}

static void predict_15(Filter *f, const double *accel_d, const double *gyro_d, const Sampling *s)
{
    predict(f, accel_d, gyro_d, s, 15);
}

static int stand_9(Filter *f, const double *gyro_d, const Pivot *p)
{
    return stand(f, gyro_d, p, 9);
}

static int stand_15(Filter *f, const double *gyro_d, const Pivot *p)
{
    return stand(f, gyro_d, p, 15);
}

/* predict(nominal, covariance, accel_d, gyro_d, dt_s, gravity_mps2, four densities) */
static PyObject *py_predict(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    (void)module;
    double numbers[6], accel_d[3], gyro_d[3];
    Opened o;
    PyObject *result = NULL;
    if (wrong_count("predict", count, 10) || read_vector(args[2], "accel_d", accel_d) < 0 ||
        read_vector(args[3], "gyro_d", gyro_d) < 0 || read_numbers(args + 4, 6, numbers) < 0)
        return NULL;
    if (open_filter(args, &o) == 0) {
        Sampling s = {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]};
        fetch(&o);
        (o.states == 9 ? predict_9 : predict_15)(&o.filter, accel_d, gyro_d, &s);
        store(&o);
        result = Py_NewRef(Py_None);
    }
    close_filter(&o);
    return result;
}

typedef struct {
    Array accel_d, gyro_d, still, out;
    int corrects, writes;
} Recording;

static int open_recording(PyObject *const *args, PyObject *still, PyObject *out, Recording *r)
{
    memset(r, 0, sizeof *r);
    r->corrects = still != Py_None;
    r->writes = out != Py_None;
    if (open_array(args[0], &r->accel_d, READ, "accel_d", "d", 2, -1, 3) < 0)
        return -1;
    Py_ssize_t n = r->accel_d.rows;
    if (open_array(args[1], &r->gyro_d, READ, "gyro_d", "d", 2, n, 3) < 0 ||
        (r->corrects && open_array(still, &r->still, READ, "still", "?", 1, n, 1) < 0) ||
        (r->writes && open_array(out, &r->out, WRITE, "out", "d", 2, n, 10) < 0))
        return -1;
    return 0;
}

static void close_recording(Recording *r)
{
    close_array(&r->accel_d);
    close_array(&r->gyro_d);
    close_array(&r->still);
    close_array(&r->out);
}

static int go_through(Opened *o, const Recording *r, const Sampling *s, const Pivot *p)
{
    int few = o->states == 9;
    for (Py_ssize_t row = 0; row < r->accel_d.rows; row++) {
        double accel_d[3], gyro_d[3];
        get_row(&r->accel_d, row, accel_d, 3);
        get_row(&r->gyro_d, row, gyro_d, 3);
        (few ? predict_9 : predict_15)(&o->filter, accel_d, gyro_d, s);
        if (r->corrects && *((const char *)r->still.buffer.buf + row * r->still.row_stride))
            if (!(few ? stand_9 : stand_15)(&o->filter, gyro_d, p))
                return -1;
        if (r->writes)
            put_row(&r->out, row, o->filter.nominal, 10);
    }
    return 0;
}

/* run(nominal, covariance, accel_d, gyro_d, dt_s, gravity_mps2, four densities, still,
 *     imu_to_pivot_d, sigma_mps, out) */
static PyObject *py_run(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    (void)module;
    double numbers[6];
    Pivot p;
    Opened o;
    Recording r;
    PyObject *result = NULL;
    if (wrong_count("run", count, 14) || read_numbers(args + 4, 6, numbers) < 0 ||
        read_vector(args[11], "imu_to_pivot_d", p.imu_to_pivot_d) < 0 ||
        read_numbers(args + 12, 1, &p.sigma_mps) < 0)
        return NULL;
    memset(&r, 0, sizeof r);
    if (open_filter(args, &o) == 0 && open_recording(args + 2, args[10], args[13], &r) == 0) {
        Sampling s = {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]};
        fetch(&o);
        if (go_through(&o, &r, &s, &p) == 0) {
            store(&o);
            result = Py_NewRef(Py_None);
        } else {
            not_positive();
        }
    }
    close_recording(&r);
    close_filter(&o);
    return result;
}

typedef struct {
    Array z, H, R, standardised;
} Measured;

static int open_measured(PyObject *const *args, int states, Measured *m)
{
    if (open_array(args[0], &m->z, READ, "z", "d", 1, -1, 1) < 0)
        return -1;
    Py_ssize_t rows = m->z.rows;
    if (rows < 1 || rows > MAX_STATES) {
        PyErr_Format(PyExc_ValueError, "z: a measurement has 1 to %d numbers, not %zd", MAX_STATES,
                     rows);
        return -1;
    }
    if (open_array(args[1], &m->H, READ, "H", "d", 2, rows, states) < 0 ||
        open_array(args[2], &m->R, READ, "R", "d", 2, rows, rows) < 0 ||
        open_array(args[3], &m->standardised, WRITE, "standardised", "d", 1, rows, 1) < 0)
        return -1;
    return 0;
}

/* W = P H^T, S = H P H^T + R, then their factors; returns whether S is positive. */
static int weigh(const Opened *o, const Measured *a, Seen *m)
{
    int rows = (int)a->z.rows, states = o->states;
    memset(m, 0, sizeof *m);
    for (int c = 0; c < states; c++) {
        double of_state[MAX_STATES];
        column((const double(*)[MAX_STATES])o->filter.P, c, states, of_state);
        for (int k = 0; k < rows; k++)
            add_row(m->W[k], at(&a->H, k, c), of_state, 0, states);
    }
    for (int k = 0; k < rows; k++) {
        m->z[k] = at(&a->z, k, 0);
        for (int l = 0; l <= k; l++) {
            m->S[k][l] = at(&a->R, k, l);
            for (int c = 0; c < states; c++)
                m->S[k][l] += at(&a->H, k, c) * m->W[l][c];
        }
    }
    return whiten(m, rows, states);
}

/* (nominal, covariance, z, H, R, standardised) -> nis */
static PyObject *measure(const char *name, PyObject *const *args, Py_ssize_t count, int correct)
{
    Opened o;
    Measured a;
    Seen m;
    PyObject *result = NULL;
    if (wrong_count(name, count, 6))
        return NULL;
    memset(&a, 0, sizeof a);
    if (open_filter(args, &o) == 0 && open_measured(args + 2, o.states, &a) == 0) {
        fetch(&o);
        if (weigh(&o, &a, &m)) {
            double nis = 0.0;
            for (int k = 0; k < (int)a.z.rows; k++) {
                double standardised = m.z[k] * sqrt(m.inverse[k]);
                nis += standardised * standardised;
                put(&a.standardised, k, 0, standardised);
            }
            if (correct) {
                take_in(&o.filter, &m, (int)a.z.rows, o.states);
                store(&o);
            }
            result = PyFloat_FromDouble(nis);
        } else {
            not_positive();
        }
    }
    close_array(&a.z);
    close_array(&a.H);
    close_array(&a.R);
    close_array(&a.standardised);
    close_filter(&o);
    return result;
}

static PyObject *py_innovation(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    (void)module;
    return measure("innovation", args, count, 0);
}

static PyObject *py_correct(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    (void)module;
    return measure("correct", args, count, 1);
}

#define FAST(function) (PyCFunction)(void (*)(void))function, METH_FASTCALL

static PyMethodDef methods[] = {
    {"predict", FAST(py_predict), "Go on by one sample."},
    {"run", FAST(py_run), "Go on by many samples."},
    {"innovation", FAST(py_innovation), "Weigh a measurement; return its nis."},
    {"correct", FAST(py_correct), "Weigh a measurement and take it in; return its nis."},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef_Slot slots[] = {{0, NULL}};

static struct PyModuleDef definition = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "_kernels",
    .m_doc = "The compiled kernels of gaitway.estimation.",
    .m_methods = methods,
    .m_slots = slots,
};

PyMODINIT_FUNC PyInit__kernels(void)
{
    return PyModuleDef_Init(&definition);
}
