// Boost odeint on the benchmark's pair: formulas T1 to T13 of docs/theory.md, states in natural sizes.
// Built by odeint_peer.py, which also writes the struct `Pair` of the numbers, in its order, into pair.hpp.

#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>

#include "pair.hpp"

namespace odeint = boost::numeric::odeint;
constexpr int STATES = 12;
constexpr int COEFFICIENTS = 14;
using State = std::array<double, STATES>;

static double involute_change(const Pair& p, const double* series, double u, double cosine, double sine) {
    if (std::abs(u) < p.u_series) {
        int terms = 8.0 * std::abs(u) < p.u_series ? 8 : COEFFICIENTS;
        double total = 0.0;
        for (int k = terms - 1; k >= 0; --k) total = total * u + series[k];
        return total * u;
    }
    double tangent = sine / cosine, alpha0 = std::acos(p.c0 / p.A0);
    return tangent - std::atan(tangent) - (std::tan(alpha0) - alpha0);
}

static double small_angle(double across, double along) {
    double x = across / along;
    if (std::abs(x) > 0.01 || along <= 0.0) return std::atan2(across, along);
    double q = x * x;
    return x * (1.0 - q * (1.0 / 3.0 - q * (0.2 - q / 7.0)));
}

static double flank(const Pair& p, double stiffness, double depth, double rate) {
    if (!(depth > 0.0)) return 0.0;
    double ramp = std::fmin(depth / p.depth, 1.0);
    return std::fmax(stiffness * depth + p.C_m * ramp * ramp * (3.0 - 2.0 * ramp) * rate, 0.0);
}

// y and dy: pinion x, y, theta, ring x, y, theta, then their rates. Returns false where the pair cannot mesh.
static bool derivative(const Pair& p, const double* series, double t, const double* y, double* dy) {
    double spin_p = p.pinion_nominal_speed + y[8], spin_r = p.ring_nominal_speed + y[11];
    double angle_p = p.pinion_nominal_speed * t + y[2] + p.pinion_eccentricity_phase;
    double angle_r = p.ring_nominal_speed * t + y[5] + p.ring_eccentricity_phase;
    double px = p.pinion_eccentricity * std::cos(angle_p), py = p.pinion_eccentricity * std::sin(angle_p);
    double rx = p.ring_eccentricity * std::cos(angle_r), ry = p.ring_eccentricity * std::sin(angle_r);
    double along = p.A0 + y[0] + px - y[3] - rx, across = y[1] + py - y[4] - ry;
    double square = along * along + across * across, A = std::sqrt(square);
    if (!(p.A_min < A && A < p.A_max)) return false;

    double cosine = p.c0 / A, sine = std::sqrt(1.0 - cosine * cosine);
    double opening = p.c0 * involute_change(p, series, square / (p.A0 * p.A0) - 1.0, cosine, sine);
    double psi = p.z_driver * (p.pinion_nominal_speed * t + y[2]), c = std::cos(psi), s = std::sin(psi);
    double lever = p.rho_a + p.rho_b;
    double error = p.e_cos * s + p.e_sin * c;
    double w = p.rho_a * y[5] + p.rho_b * y[2] - lever * small_angle(across, along) + error;
    double depth_d = w + opening, depth_b = -w + opening - p.backlash;

    double f_x = 0.0, f_y = 0.0, drive = 0.0, back = 0.0;
    if (depth_d > 0.0 || depth_b > 0.0) {
        double e_x = along / A, e_y = across / A;
        double v_x = y[6] - spin_p * py - y[9] + spin_r * ry, v_y = y[7] + spin_p * px - y[10] - spin_r * rx;
        double error_rate = (p.e_cos * c - p.e_sin * s) * p.z_driver * spin_p;
        double w_rate = p.rho_a * y[11] + p.rho_b * y[8] - lever * (v_y * e_x - v_x * e_y) / A + error_rate;
        double opening_rate = sine * (v_x * e_x + v_y * e_y);
        double stiffness = p.k_m + p.k_cos * c - p.k_sin * s;
        drive = flank(p, stiffness, depth_d, w_rate + opening_rate);
        back = flank(p, stiffness, depth_b, -w_rate + opening_rate);
        double both = (drive + back) * sine, difference = (drive - back) * cosine;
        f_x = -both * e_x + difference * e_y;
        f_y = -both * e_y - difference * e_x;
    }
    double distance = std::sqrt(y[3] * y[3] + y[4] * y[4]), deep = distance - p.clearance;
    double push = deep > 0.0 ? p.sleeve_stiffness * deep * std::sqrt(deep) / distance : 0.0;
    double twist = drive - back;
    double torque_p = p.pinion_torque - p.pinion_drag * spin_p - twist * p.rho_b + px * f_y - py * f_x;
    double torque_r = p.ring_torque - p.ring_drag * spin_r - twist * p.rho_a - rx * f_y + ry * f_x;
    for (int i = 0; i < STATES / 2; ++i) dy[i] = y[STATES / 2 + i];
    dy[6] = p.pinion_inv_mass * f_x;
    dy[7] = p.pinion_inv_mass * f_y;
    dy[8] = p.pinion_inv_inertia * torque_p;
    dy[9] = p.ring_inv_mass * (-f_x - push * y[3]);
    dy[10] = p.ring_inv_mass * (-f_y - push * y[4]);
    dy[11] = p.ring_inv_inertia * torque_r;
    return true;
}

template <class Stepper>
static int march(Stepper stepper, const Pair& p, const double* series, const double* natural, double outside,
                 double span, double dt, long limit, State& z, long& evaluations) {
    auto rate = [&](const State& scaled, State& scaled_rate, double t) {
        State y;
        ++evaluations;
        for (int i = 0; i < STATES; ++i) y[i] = scaled[i] * natural[i];
        if (!derivative(p, series, t, y.data(), scaled_rate.data())) {
            scaled_rate.fill(outside);  // an error test turns the trial step down
            return;
        }
        for (int i = 0; i < STATES; ++i) scaled_rate[i] /= natural[i];
    };
    double t = 0.0;
    while (t < span) {
        if (t + dt > span) dt = span - t;
        if (evaluations > limit || !(t + dt > t)) return 1;
        stepper.try_step(rate, z, t, dt);
    }
    return 0;
}

extern "C" int pair_derivative(const Pair* p, const double* series, double t, const double* y, double* dy) {
    return derivative(*p, series, t, y, dy) ? 0 : 1;
}

extern "C" int pair_solve(const Pair* p, const double* series, const double* natural, double outside,
                          int method, double tolerance, double span, double first_step, long limit, double* y,
                          long* evaluations) {
    State z;
    *evaluations = 0;
    for (int i = 0; i < STATES; ++i) z[i] = y[i] / natural[i];
    int failed;
    if (method == 0) {
        auto stepper = odeint::make_controlled(tolerance, 0.0, odeint::runge_kutta_dopri5<State>());
        failed = march(stepper, *p, series, natural, outside, span, first_step, limit, z, *evaluations);
    } else {
        auto stepper = odeint::make_controlled(tolerance, 0.0, odeint::runge_kutta_fehlberg78<State>());
        failed = march(stepper, *p, series, natural, outside, span, first_step, limit, z, *evaluations);
    }
    for (int i = 0; i < STATES; ++i) y[i] = z[i] * natural[i];
    return failed;
}
