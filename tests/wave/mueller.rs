//! Mueller calculus for expected values, by definition.

/// A Stokes vector or a row of a Mueller matrix.
pub(crate) type Four = [f64; 4];

/// Stokes vectors in a frame that is turned by `t` radians counter-clockwise, as the observer sees it.
pub(crate) fn turned(t: f64, s: Four) -> Four {
    let (sin, cos) = (2.0 * t).sin_cos();
    [s[0], cos * s[1] + sin * s[2], cos * s[2] - sin * s[1], s[3]]
}

/// Behind an ideal polarizer that transmits along the angle `t`.
pub(crate) fn polarizer(t: f64, s: Four) -> Four {
    let [s0, s1, ..] = turned(t, s);
    let half = 0.5 * (s0 + s1);
    turned(-t, [half, half, 0.0, 0.0])
}

/// Behind a retarder with its fast axis at the angle `t`; `delta` is the lead of the fast axis, radians.
pub(crate) fn retarder(t: f64, delta: f64, s: Four) -> Four {
    let (sin, cos) = delta.sin_cos();
    let s = turned(t, s);
    turned(
        -t,
        [s[0], s[1], cos * s[2] + sin * s[3], cos * s[3] - sin * s[2]],
    )
}

/// Behind a circular polarizer that passes S3 > 0.
pub(crate) fn circular(s: Four) -> Four {
    let half = 0.5 * (s[0] + s[3]);
    [half, 0.0, 0.0, half]
}
