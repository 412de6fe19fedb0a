//! Numbers in \[0, 1): the largest, and the choice of one of several masses by one of them.

/// The largest number below 1 that stays below a total when multiplied by it.
pub(crate) const BELOW_ONE: f64 = 1.0 - f64::EPSILON;

/// Of several masses laid end to end the one that contains `at`, and where in it, in \[0, 1).
///
/// With `at` = u · total this turns one uniform number into a choice and a new uniform number. A
/// mass of 0 is never chosen. Past the end the last one is; `None` where there is none.
#[inline]
pub(crate) fn choose<T>(masses: impl Iterator<Item = (T, f64)>, mut at: f64) -> Option<(T, f64)> {
    let mut chosen = None;
    for (one, mass) in masses.filter(|(_, mass)| *mass > 0.0) {
        chosen = Some((one, (at / mass).min(BELOW_ONE)));
        if at < mass {
            break;
        }
        at -= mass;
    }
    chosen
}

/// [`choose`] of four masses by u, without branches: a walk down a tree does it at every level.
#[inline]
pub(crate) fn choose_of_four(masses: [f64; 4], u: f64) -> Option<(usize, f64)> {
    let first = masses[0];
    let second = first + masses[1];
    let third = second + masses[2];
    let total = third + masses[3];
    if total <= 0.0 {
        return None;
    }
    // Less than the total, as u is at most BELOW_ONE: so past a trailing 0 it never falls.
    let at = u * total;
    let digit = usize::from(at >= first) + usize::from(at >= second) + usize::from(at >= third);
    let start = [0.0, first, second, third][digit];
    Some((digit, ((at - start) / masses[digit]).min(BELOW_ONE)))
}

/// Whether `u` falls in the second of two masses, and its place there in \[0, 1). A mass of 0 is
/// never chosen.
#[inline(always)]
pub(crate) fn choose_of_two(first: f64, second: f64, u: f64) -> (bool, f64) {
    let at = u * (first + second);
    let beyond = at >= first;
    let place = if beyond { (at - first) / second } else { at / first };
    (beyond, place.min(BELOW_ONE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choice_skips_nothing_and_zero() {
        assert_eq!(choose_of_four([0.0, 1.0, 0.0, 3.0], 0.0), Some((1, 0.0)));
        assert_eq!(choose_of_four([0.0, 1.0, 0.0, 3.0], 0.25), Some((3, 0.0)));
        assert_eq!(choose_of_four([0.0, 1.0, 0.0, 0.0], 0.999_999).map(|c| c.0), Some(1));
        assert_eq!(choose_of_four([0.0; 4], 0.5), None);
    }

    /// The loop is the slow twin of both.
    #[test]
    fn few_masses_are_chosen_from_as_many_are() {
        for masses in [[0.0, 1.0, 0.0, 3.0], [2.0, 0.0, 0.5, 0.25], [0.0, 0.0, 0.0, 1.0]] {
            for u in (0..=1000).map(|k| (f64::from(k) / 1000.0).min(BELOW_ONE)) {
                let total = masses.iter().sum::<f64>();
                let (index, place) = choose(masses.into_iter().enumerate(), u * total).unwrap();
                let (four, there) = choose_of_four(masses, u).unwrap();
                assert_eq!(four, index, "{masses:?} {u}");
                assert!((there - place).abs() < 1e-12, "{masses:?} {u}");
                let [first, second, ..] = masses;
                let (beyond, there) = choose_of_two(first, second, u);
                let two = choose([first, second].into_iter().enumerate(), u * (first + second));
                let Some((index, place)) = two else { continue };
                assert_eq!(beyond, index == 1, "{masses:?} {u}");
                assert!((there - place).abs() < 1e-12, "{masses:?} {u}");
            }
        }
    }

    #[test]
    fn past_the_end_is_the_last_that_is_anything() {
        assert_eq!(choose([('a', 1.0), ('b', 0.0)].into_iter(), 1.0), Some(('a', BELOW_ONE)));
        assert_eq!(choose([('a', 0.0)].into_iter(), 0.0), None);
    }
}
