/* The power function of musl, with all that it needs, in one file. */
#include "pow.c"
#include "pow_data.c"
#include "exp_data.c"
#include "__math_invalid.c"
#include "__math_oflow.c"
#include "__math_uflow.c"
#include "__math_xflow.c"
#include "__math_divzero.c"
