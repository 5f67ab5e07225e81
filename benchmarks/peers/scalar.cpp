// The algorithm of numba_scalar.py in C++ with OpenMP: g++ -O3 -march=native -fopenmp -shared -fPIC (cpp_scalar.py compiles it).
#include <algorithm>
#include <cmath>

namespace {

constexpr double A2 = 0.1, A3 = 0.3, A4 = 0.1, MU_START = 1.3, ATOL = 1e-3;

constexpr double A21 = 0.161, A31 = -0.008480655492356989, A32 = 0.335480655492357, A41 = 2.8971530571054935,
                 A42 = -6.359448489975075, A43 = 4.3622954328695815, A51 = 5.325864828439257, A52 = -11.748883564062828,
                 A53 = 7.4955393428898365, A54 = -0.09249506636175525, A61 = 5.86145544294642, A62 = -12.92096931784711,
                 A63 = 8.159367898576159, A64 = -0.071584973281401, A65 = -0.028269050394068383,
                 A71 = 0.09646076681806523, A72 = 0.01, A73 = 0.4798896504144996, A74 = 1.379008574103742,
                 A75 = -3.290069515436081, A76 = 2.324710524099774;
constexpr double E1 = -0.00178001105222577714, E2 = -0.0008164344596567469, E3 = 0.007880878010261995,
                 E4 = -0.1447110071732629, E5 = 0.5823571654525552, E6 = -0.45808210592918697, E7 = 0.015151515151515152;

struct Step {
    double y, w, dw, error_y, error_w;
};

inline double slip(double y, double w) { return y - A2 * w - A3 * (std::exp(-w / A4) - 1.0); }

inline Step step(double k, double belt, double h, double y, double w, double k1) {
    const double d1 = k * (belt - w);
    const double w2 = w + h * (A21 * k1), y2 = y + h * (A21 * d1);
    const double d2 = k * (belt - w2), k2 = slip(y2, w2);
    const double w3 = w + h * (A31 * k1 + A32 * k2), y3 = y + h * (A31 * d1 + A32 * d2);
    const double d3 = k * (belt - w3), k3 = slip(y3, w3);
    const double w4 = w + h * (A41 * k1 + A42 * k2 + A43 * k3), y4 = y + h * (A41 * d1 + A42 * d2 + A43 * d3);
    const double d4 = k * (belt - w4), k4 = slip(y4, w4);
    const double w5 = w + h * (A51 * k1 + A52 * k2 + A53 * k3 + A54 * k4);
    const double y5 = y + h * (A51 * d1 + A52 * d2 + A53 * d3 + A54 * d4);
    const double d5 = k * (belt - w5), k5 = slip(y5, w5);
    const double w6 = w + h * (A61 * k1 + A62 * k2 + A63 * k3 + A64 * k4 + A65 * k5);
    const double y6 = y + h * (A61 * d1 + A62 * d2 + A63 * d3 + A64 * d4 + A65 * d5);
    const double d6 = k * (belt - w6), k6 = slip(y6, w6);
    const double w7 = w + h * (A71 * k1 + A72 * k2 + A73 * k3 + A74 * k4 + A75 * k5 + A76 * k6);
    const double y7 = y + h * (A71 * d1 + A72 * d2 + A73 * d3 + A74 * d4 + A75 * d5 + A76 * d6);
    const double d7 = k * (belt - w7), k7 = slip(y7, w7);
    return {y7, w7, k7, h * (E1 * d1 + E2 * d2 + E3 * d3 + E4 * d4 + E5 * d5 + E6 * d6 + E7 * d7),
            h * (E1 * k1 + E2 * k2 + E3 * k3 + E4 * k4 + E5 * k5 + E6 * k6 + E7 * k7)};
}

// Where in a step w falls to zero: time from its start; y there in y_root.
double locate(double k, double belt, double h, double y, double w, double k1, const Step& end, double& y_root) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 20; ++i) {
        const double s = 0.5 * (low + high), r = 1.0 - s;
        const double value = (1.0 + 2.0 * s) * r * r * w + s * r * r * h * k1 + s * s * (3.0 - 2.0 * s) * end.w -
                             s * s * r * h * end.dw;
        (value > 0.0 ? low : high) = s;
    }
    double part = 0.5 * (low + high) * h;
    for (int i = 0; i < 8; ++i) {
        const Step there = step(k, belt, part, y, w, k1);
        const double change = -there.w / there.dw;
        y_root = there.y;
        if (std::abs(change) < 1e-12 * (1.0 + part)) {
            y_root += change * k * belt;
            return part + change;
        }
        part = std::min(std::max(part + change, 0.0), h);
    }
    return part;
}

void trajectory(double k, double belt, double horizon, double rtol, double* out) {
    const double atol = ATOL * rtol, stiffness_time = 1.0 / std::sqrt(k);
    double t = 0.0, x = 0.0;
    bool first = true;
    for (;;) {
        const double release = t + (MU_START / k - x) / belt;
        if (release >= horizon) {
            out[2] = x + belt * (horizon - t), out[3] = belt;
            return;
        }
        t = release;
        double y = 0.0, w = 0.0, k1 = 0.0, h = 1e-3 * stiffness_time;
        for (;;) {
            h = std::min(h, horizon - t);
            const Step end = step(k, belt, h, y, w, k1);
            const double scale_y = atol + rtol * std::max(std::abs(y), std::abs(end.y));
            const double scale_w = atol + rtol * std::max(std::abs(w), std::abs(end.w));
            const double ey = end.error_y / scale_y, ew = end.error_w / scale_w;
            const double error = std::sqrt(0.5 * (ey * ey + ew * ew));
            const double factor = std::min(5.0, std::max(0.2, 0.9 * std::pow(std::max(error, 1e-10), -0.2)));
            if (!(error <= 1.0)) {
                h *= std::min(factor, 0.9);
                continue;
            }
            if (end.w <= 0.0) {
                double y_root;
                t += locate(k, belt, h, y, w, k1, end, y_root);
                x = (y_root + MU_START) / k;
                if (first) out[0] = t, out[1] = x, first = false;
                break;
            }
            t += h, y = end.y, w = end.w, k1 = end.dw;
            if (t >= horizon) {
                out[2] = (y + MU_START) / k, out[3] = belt - w;
                return;
            }
            h *= factor;
        }
    }
}

}  // namespace

// out: n rows of first re-stick time and x, final x and v; filled with NaN by the caller.
extern "C" void solve(long n, const double* k, const double* belt, double horizon, double rtol, int threads, double* out) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
    for (long i = 0; i < n; ++i) trajectory(k[i], belt[i], horizon, rtol, out + 4 * i);
}
