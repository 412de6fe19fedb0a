//! Building trees: every wrong call is refused, what was built comes out again.

mod support;

use bsdfkit::tree::{MAX_DEPTH, Rank, TensorTree, TreeBuilder, TreeVisitor};
use bsdfkit::{DVec2, ErrorClass, Result, Side};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use proptest::prelude::*;
use support::{Random, random_tree};

const RANKS: [Rank; 2] = [Rank::Three, Rank::Four];

fn rebuilt(tree: &TensorTree) -> TensorTree {
    let mut b = TreeBuilder::new(tree.rank());
    tree.visit(&mut b).unwrap();
    b.finish().unwrap()
}

/// Splits every leaf into a branch of equal leaves, grids into finer grids.
struct Splitter(TreeBuilder, usize);

impl TreeVisitor for Splitter {
    fn open_branch(&mut self) -> Result<()> {
        self.0.open_branch()
    }
    fn leaf(&mut self, value: f32) -> Result<()> {
        self.0.grid(1, &vec![value; self.1])
    }
    fn grid(&mut self, log2: u32, values: &[f32]) -> Result<()> {
        assert_eq!(log2, 1);
        // C order of the grid, text order of the children.
        let rank = values.len().trailing_zeros();
        self.0.open_branch()?;
        for child in 0..values.len() {
            let place = (0..rank).fold(0, |place, d| place << 1 | (child >> d & 1));
            self.leaf(values[place])?;
        }
        self.0.close_branch()
    }
    fn close_branch(&mut self) -> Result<()> {
        self.0.close_branch()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn visit_is_the_inverse_of_build(seed: u64, depth in 1_u32..4) {
        for rank in RANKS {
            let tree = random_tree(rank, depth, 0.0, &mut Random(seed));
            prop_assert_eq!(&rebuilt(&tree), &tree);
            prop_assert!(tree.depth() <= depth);
        }
    }

    #[test]
    fn splitting_leaves_changes_no_value_and_no_mean(seed: u64) {
        for rank in RANKS {
            let mut random = Random(seed);
            let tree = random_tree(rank, 3, 0.0, &mut random);
            let mut splitter = Splitter(TreeBuilder::new(rank), rank.children());
            tree.visit(&mut splitter).unwrap();
            let split = splitter.0.finish().unwrap();
            prop_assert_eq!(split.leaf_count(), tree.leaf_count() * rank.children());
            prop_assert!((split.mean() - tree.mean()).abs() < 1e-12);
            prop_assert_eq!(split.range(), tree.range());
            for _ in 0..50 {
                let (wi, wo) = (random.direction(Side::Front), random.direction(Side::Back));
                let ((a, level), (b, finer)) = (tree.leaf_at(wi, wo), split.leaf_at(wi, wo));
                prop_assert_eq!(a, b);
                prop_assert_eq!(level + 1, finer);
            }
        }
    }
}

/// Each cell of a grid, by its place in C order, from the directions at its centre.
#[test]
fn grid_is_in_c_order() {
    let values: Vec<f32> = (0..4_u16.pow(4)).map(f32::from).collect();
    let mut b = TreeBuilder::new(Rank::Four);
    b.grid(2, &values).unwrap();
    let tree = b.finish().unwrap();
    for (place, &value) in values.iter().enumerate() {
        let c = |shift: usize| ((place >> shift & 3) as f64 + 0.5) / 4.0;
        let travel = square_to_hemisphere(DVec2::new(c(6), c(4)), Side::Back);
        let wo = square_to_hemisphere(DVec2::new(c(2), c(0)), Side::Front);
        assert_eq!(tree.leaf_at(-travel, wo).0, value);
    }
}

#[test]
fn wrong_calls_name_the_place() {
    let refused = |calls: &dyn Fn(&mut TreeBuilder) -> Result<()>| {
        let mut b = TreeBuilder::new(Rank::Three);
        let error = calls(&mut b).and_then(|()| b.finish().map(drop)).unwrap_err();
        (error.class(), error.to_string())
    };
    let (class, text) = refused(&|b| {
        b.open_branch()?;
        b.leaf(1.0)?;
        b.open_branch()?;
        b.leaf(f32::NAN)
    });
    assert_eq!(class, ErrorClass::Argument);
    assert_eq!(text, "tree/1/0: expected a finite value of at least 0, found NaN");
    assert!(refused(&|b| b.leaf(-1.0)).1.contains("found -1"));
    assert!(refused(&|b| b.leaf(f32::INFINITY)).1.contains("found inf"));
    assert!(refused(&|_| Ok(())).1.contains("found nothing"));
    assert!(refused(&TreeBuilder::open_branch).1.contains("ends inside a branch"));
    assert!(refused(&TreeBuilder::close_branch).1.contains("never opened"));
    assert!(refused(&|b| b.leaf(1.0).and_then(|()| b.leaf(1.0))).1.contains("another root"));
    let few = refused(&|b| b.open_branch().and_then(|()| b.close_branch()));
    assert!(few.1.contains("expected 8 children, found 0"), "{}", few.1);
    let many = refused(&|b| {
        b.open_branch()?;
        (0..9).try_for_each(|_| b.leaf(0.0))
    });
    assert!(many.1.contains("expected 8 children, found more"), "{}", many.1);
    assert!(
        refused(&|b| b.grid(1, &[0.0; 16])).1.contains("expected a grid of 8 values, found 16")
    );
}

#[test]
fn depth_is_limited() {
    for rank in RANKS {
        let mut b = TreeBuilder::new(rank);
        (0..MAX_DEPTH).for_each(|_| b.open_branch().unwrap());
        assert_eq!(b.open_branch().unwrap_err().class(), ErrorClass::Limit);
        let mut b = TreeBuilder::new(rank);
        assert_eq!(b.grid(17, &[]).unwrap_err().class(), ErrorClass::Limit);
        assert_eq!(b.grid(u32::MAX, &[]).unwrap_err().class(), ErrorClass::Limit);
        assert_eq!(b.grid(16, &[]).unwrap_err().class(), ErrorClass::Argument);
    }
}

/// A path to the deepest leaf: looked up, sampled and summed without trouble.
#[test]
fn the_deepest_tree_answers() {
    use bsdfkit::tree::TreeDistribution;
    use bsdfkit::{Bsdf, Component, Components, Lambertian, Metadata};
    for rank in RANKS {
        let children = rank.children();
        let mut b = TreeBuilder::new(rank);
        for _ in 0..MAX_DEPTH {
            b.open_branch().unwrap();
        }
        b.leaf(1e9).unwrap();
        for _ in 0..MAX_DEPTH {
            (1..children).for_each(|_| b.leaf(0.0).unwrap());
            b.close_branch().unwrap();
        }
        let tree = b.finish().unwrap();
        assert_eq!(tree.depth(), MAX_DEPTH);
        let c = Component::new(Side::Back, Side::Front, TreeDistribution::new(tree));
        let bsdf = Bsdf::new(Metadata::default(), vec![c], Lambertian::default());
        // The first cell of all: grazing, and the corner of the scattered square.
        let corner = square_to_hemisphere(DVec2::splat(1e-6), Side::Front);
        let wi = match rank {
            Rank::Three => -bsdfkit::DVec3::X,
            Rank::Four => -square_to_hemisphere(DVec2::splat(1e-6), Side::Front),
        };
        let s = bsdf.sample(wi, 0.7, Components::ALL).unwrap();
        assert!((s.wo - corner).truncate().length() < 1e-4, "{}", s.wo);
        assert_eq!(bsdf.eval(wi, s.wo), 1e9);
        let (low, high) = bsdf.projected_solid_angle(wi, None);
        assert!(low < 1e-9 && high > 0.7, "{low} {high}");
    }
}
