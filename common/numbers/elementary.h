#pragma once

/// Elementary functions whose bits are the same on every processor. The C library's are not: glibc
/// picks variants by processor (with FMA or without), and changes them between versions. So no
/// number that can reach an observation, a reward, an action, the weights or a statistic may come
/// from `<cmath>`, but for what IEEE 754 rounds exactly (sqrt, fma) and what rounds to integers;
/// tests/layers holds this.
///
/// Source: SLEEF's scalar functions without FMA (Shibata and Petrogalli, IEEE TPDS 2020,
/// sleef.org), which are plain double arithmetic in a fixed order.
/// Accuracy: at most 1 ulp from the true value, over all doubles; subnormal arguments and results
/// included. Zeros, infinities and NaN are as in C's Annex F; errno is left alone. The one
/// exception: where the true value is within 2e-9 (as a share) of the largest double, Exp and Pow
/// may give infinity.
namespace metronome::numbers {

double Exp(double x);
/// Natural logarithm. Of a negative number: NaN; of a zero: minus infinity.
double Log(double x);
/// Of radians, however many.
double Sin(double x);
double Cos(double x);
double Pow(double x, double y);

/// The double's result, rounded: within 0.51 ulp of float.
float Exp(float x);

}  // namespace metronome::numbers
