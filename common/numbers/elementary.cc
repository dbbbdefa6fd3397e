#include "common/numbers/elementary.h"

#include <sleef.h>

// Of SLEEF's variants: "cinz" uses no FMA and gives equal results wherever it is compiled, "u10" is
// within 1.0 ulp, "purec" is plain C.
namespace metronome::numbers {

double Exp(double x) { return Sleef_cinz_expd1_u10purec(x); }

double Log(double x) { return Sleef_cinz_logd1_u10purec(x); }

double Sin(double x) { return Sleef_cinz_sind1_u10purec(x); }

double Cos(double x) { return Sleef_cinz_cosd1_u10purec(x); }

double Pow(double x, double y) { return Sleef_cinz_powd1_u10purec(x, y); }

float Exp(float x) { return static_cast<float>(Exp(double{x})); }

}  // namespace metronome::numbers
