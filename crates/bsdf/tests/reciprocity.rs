//! The reciprocal mean of trees of any shape, by comparing values pair by pair.

mod support;

use bsdfkit::Side;
use bsdfkit::reciprocity::reciprocal_mean;
use bsdfkit::tree::Rank;
use proptest::prelude::*;
use support::{Random, random_tree};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn both_travel_directions_agree(seed: u64) {
        let mut random = Random(seed);
        let f = random_tree(Rank::Four, 3, 0.0, &mut random);
        let g = random_tree(Rank::Four, 2, 0.0, &mut random);
        let (there, back) = (reciprocal_mean(&f, &g).unwrap(), reciprocal_mean(&g, &f).unwrap());
        prop_assert!((there.mean() - 0.5 * (f.mean() + g.mean())).abs() < 1e-7);
        for _ in 0..200 {
            let (i, o) = (random.direction(Side::Front), random.direction(Side::Back));
            let expected = 0.5 * f.leaf_at(i, o).0 + 0.5 * g.leaf_at(o, i).0;
            prop_assert_eq!(there.leaf_at(i, o).0, expected);
            prop_assert_eq!(back.leaf_at(o, i).0, expected);
        }
    }
}
