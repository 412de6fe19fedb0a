//! Between the nodes of a grid: which two, with which weights.

/// The two of rising numbers about `x` with their weights; the end where `x` is past it.
pub fn between(rising: &[f64], x: f64) -> [(usize, f64); 2] {
    let after = rising.partition_point(|v| *v <= x);
    let last = rising.len() - 1;
    match after {
        0 => [(0, 1.0), (0, 0.0)],
        _ if after > last => [(last, 1.0), (last, 0.0)],
        _ => {
            let t = (x - rising[after - 1]) / (rising[after] - rising[after - 1]);
            [(after - 1, 1.0 - t), (after, t)]
        }
    }
}

/// The same around a turn of `turn`: after the last comes the first.
pub fn around(rising: &[f64], x: f64, turn: f64) -> [(usize, f64); 2] {
    let x = rising[0] + (x - rising[0]).rem_euclid(turn);
    let last = rising.len() - 1;
    if x <= rising[last] || last == 0 {
        return between(rising, x);
    }
    let t = (x - rising[last]) / (rising[0] + turn - rising[last]);
    [(last, 1.0 - t), (0, t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn around_a_turn_the_first_comes_after_the_last() {
        let quarters = [0.0, 90.0, 180.0, 270.0];
        assert_eq!(around(&quarters, 315.0, 360.0), [(3, 0.5), (0, 0.5)]);
        assert_eq!(around(&quarters, -45.0, 360.0), [(3, 0.5), (0, 0.5)]);
        assert_eq!(around(&quarters, 45.0, 360.0), [(0, 0.5), (1, 0.5)]);
        assert_eq!(around(&[30.0], 77.0, 360.0), [(0, 1.0), (0, 0.0)]);
        // A whole turn written out: what is past the last is rounding.
        assert_eq!(around(&[0.0, 360.0], 90.0, 360.0), [(0, 0.75), (1, 0.25)]);
    }

    #[test]
    fn past_the_ends_the_ends_stand() {
        assert_eq!(between(&[10.0, 20.0], 5.0), [(0, 1.0), (0, 0.0)]);
        assert_eq!(between(&[10.0, 20.0], 20.0), [(1, 1.0), (1, 0.0)]);
        assert_eq!(between(&[10.0, 20.0], 12.5), [(0, 0.75), (1, 0.25)]);
    }
}
