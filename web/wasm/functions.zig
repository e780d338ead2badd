// Elementary functions that Zig's standard library has, ported from musl, under the names that Numba calls.
const math = @import("std").math;

export fn atan2(y: f64, x: f64) f64 {
    return math.atan2(y, x);
}

export fn expm1(x: f64) f64 {
    return math.expm1(x);
}

export fn log1p(x: f64) f64 {
    return math.log1p(x);
}

export fn tanh(x: f64) f64 {
    return math.tanh(x);
}
