//! Layouts of a rank-4 tree, and how each is made of the tree as stored.

use std::collections::HashMap;

use half::f16;

pub(crate) const BRANCH: u32 = 1 << 31;
/// A layout. `at` is a slot: a leaf without its highest bit, else what the layout makes of it.
pub(crate) trait Layout {
    /// Steps from the root to the deepest leaf.
    fn steps(&self) -> u32;
    fn root(&self) -> u32;
    /// The slot below a branch, for step number `step`; tells the address that it reads.
    fn step(&self, at: u32, key: u32, step: u32, read: impl FnMut(usize)) -> u32;
    /// The value of a leaf's slot.
    fn value(&self, at: u32, read: impl FnMut(usize)) -> f32;
    fn bytes(&self) -> usize;
}

pub(crate) fn address<T>(element: &T) -> usize {
    std::ptr::from_ref(element) as usize
}

/// The four bits of a level: incident y, x, scattered y, x.
pub(crate) fn part(key: u32, level: u32) -> usize {
    (key >> (4 * (7 - level)) & 15) as usize
}

/// 2^BITS children a branch, inline: a slot is a branch's number or a value's bits.
pub(crate) struct Inline<const BITS: u32> {
    pub(crate) slots: Vec<u32>,
    pub(crate) root: u32,
    pub(crate) depth: u32,
}

impl<const BITS: u32> Layout for Inline<BITS> {
    fn steps(&self) -> u32 {
        self.depth * 4 / BITS
    }
    fn root(&self) -> u32 {
        self.root
    }
    fn step(&self, at: u32, key: u32, step: u32, mut read: impl FnMut(usize)) -> u32 {
        let child = key >> (32 - BITS * (step + 1)) & ((1 << BITS) - 1);
        let slot = &self.slots[(at << BITS | child) as usize];
        read(address(slot));
        *slot
    }
    fn value(&self, at: u32, _: impl FnMut(usize)) -> f32 {
        f32::from_bits(at)
    }
    fn bytes(&self) -> usize {
        4 * self.slots.len()
    }
}

/// A value of a leaf in an array.
pub(crate) trait Stored: Copy {
    fn of(value: f32) -> Self;
    fn get(self) -> f32;
}

impl Stored for f32 {
    fn of(value: f32) -> Self {
        value
    }
    fn get(self) -> f32 {
        self
    }
}

impl Stored for f16 {
    fn of(value: f32) -> Self {
        Self::from_f32(value)
    }
    fn get(self) -> f32 {
        self.to_f32()
    }
}

/// Branches and leaves apart: a branch says which of its children are branches; both lie side by side.
#[derive(Clone, Copy, Default)]
pub(crate) struct Masked {
    pub(crate) branches: u32,
    pub(crate) leaves: u32,
    pub(crate) mask: u16,
}

pub(crate) struct Apart<T> {
    pub(crate) nodes: Vec<Masked>,
    pub(crate) leaves: Vec<T>,
    pub(crate) depth: u32,
}

impl<T: Stored> Layout for Apart<T> {
    fn steps(&self) -> u32 {
        self.depth
    }
    fn root(&self) -> u32 {
        BRANCH
    }
    fn step(&self, at: u32, key: u32, step: u32, mut read: impl FnMut(usize)) -> u32 {
        let node = &self.nodes[(at ^ BRANCH) as usize];
        read(address(node));
        let child = part(key, step);
        let before = node.mask & ((1 << child) - 1);
        if node.mask >> child & 1 == 1 {
            BRANCH | (node.branches + before.count_ones())
        } else {
            node.leaves + child as u32 - before.count_ones()
        }
    }
    fn value(&self, at: u32, mut read: impl FnMut(usize)) -> f32 {
        let leaf = &self.leaves[at as usize];
        read(address(leaf));
        leaf.get()
    }
    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.leaves)
    }
}

/// As [`Inline`], but a branch of 16 leaves is a block of their values in f16: half a line.
pub(crate) struct Blocks {
    pub(crate) slots: Vec<u32>,
    pub(crate) blocks: Vec<[f16; 16]>,
    pub(crate) depth: u32,
}

/// Marks a slot that holds the number of a block.
pub(crate) const BLOCK: u32 = BRANCH | 1 << 30;

impl Layout for Blocks {
    fn steps(&self) -> u32 {
        self.depth
    }
    fn root(&self) -> u32 {
        BRANCH
    }
    fn step(&self, at: u32, key: u32, step: u32, mut read: impl FnMut(usize)) -> u32 {
        let child = part(key, step);
        if at & BLOCK == BLOCK {
            let leaf = &self.blocks[(at ^ BLOCK) as usize][child];
            read(address(leaf));
            return leaf.to_f32().to_bits();
        }
        let slot = &self.slots[((at ^ BRANCH) << 4) as usize | child];
        read(address(slot));
        *slot
    }
    fn value(&self, at: u32, _: impl FnMut(usize)) -> f32 {
        f32::from_bits(at)
    }
    fn bytes(&self) -> usize {
        4 * self.slots.len() + size_of_val(&*self.blocks)
    }
}

/// The tree as the library stores it.
pub(crate) struct Tree<'a> {
    pub(crate) slots: &'a [u32],
    pub(crate) root: u32,
    pub(crate) depth: u32,
}

impl Tree<'_> {
    pub(crate) fn children(&self, branch: u32) -> &[u32] {
        &self.slots[((branch ^ BRANCH) as usize) << 4..][..16]
    }

    /// Branches, level by level.
    pub(crate) fn by_level(&self) -> Vec<u32> {
        let (mut order, mut first) = (vec![self.root], 0);
        while first < order.len() {
            let below = self.children(order[first]).iter().filter(|s| **s & BRANCH != 0);
            let below: Vec<u32> = below.copied().collect();
            order.extend(below);
            first += 1;
        }
        order
    }

    /// Branches renumbered in the given order.
    pub(crate) fn placed(&self, order: &[u32]) -> Inline<4> {
        let place: HashMap<u32, u32> =
            order.iter().enumerate().map(|(n, b)| (*b, n as u32 | BRANCH)).collect();
        let moved = |s: &u32| if s & BRANCH == 0 { *s } else { place[s] };
        let slots = order.iter().flat_map(|b| self.children(*b)).map(moved).collect();
        Inline { slots, root: place[&self.root], depth: self.depth }
    }

    /// Every subtree that occurs again is stored once.
    pub(crate) fn shared(&self) -> Inline<4> {
        let (mut known, mut slots, mut place) = (HashMap::new(), Vec::new(), HashMap::new());
        for branch in self.by_level().into_iter().rev() {
            let moved = |s: &u32| if s & BRANCH == 0 { *s } else { place[s] };
            let node: Vec<u32> = self.children(branch).iter().map(moved).collect();
            let next = slots.len() as u32 >> 4 | BRANCH;
            let found = *known.entry(node.clone()).or_insert(next);
            if found == next {
                slots.extend(node);
            }
            place.insert(branch, found);
        }
        Inline { slots, root: place[&self.root], depth: self.depth }
    }

    /// Each branch as a tree of branches of 2^BITS; equal leaves side by side become one.
    pub(crate) fn split<const BITS: u32>(&self) -> Inline<BITS> {
        let mut made = Inline { slots: Vec::new(), root: BRANCH, depth: self.depth };
        let root = self.split_into(&mut made, self.root, 0, 4);
        Inline { root, ..made }
    }

    /// Children from number `from` on, 2^bits of them, of a branch: the slot that leads to them.
    pub(crate) fn split_into<const B: u32>(
        &self,
        to: &mut Inline<B>,
        at: u32,
        from: u32,
        bits: u32,
    ) -> u32 {
        if at & BRANCH == 0 {
            return at;
        }
        if bits == 0 {
            let child = self.children(at)[from as usize];
            return self.split_into(to, child, 0, if child & BRANCH == 0 { 0 } else { 4 });
        }
        let place = to.slots.len();
        to.slots.resize(place + (1 << B), 0);
        for child in 0..1 << B {
            let below = self.split_into(to, at, from + (child << (bits - B)), bits - B);
            to.slots[place + child as usize] = below;
        }
        let first = to.slots[place];
        if first & BRANCH == 0 && to.slots[place..].iter().all(|s| *s == first) {
            to.slots.truncate(place);
            return first;
        }
        place as u32 >> B | BRANCH
    }

    pub(crate) fn blocks(&self) -> Blocks {
        let is_block = |b: u32| self.children(b).iter().all(|s| s & BRANCH == 0);
        let (mut inner, mut blocks, mut place) = (Vec::new(), Vec::new(), HashMap::new());
        for branch in self.by_level() {
            if is_block(branch) && branch != self.root {
                place.insert(branch, blocks.len() as u32 | BLOCK);
                let value = |k: usize| f16::from_f32(f32::from_bits(self.children(branch)[k]));
                blocks.push(std::array::from_fn(value));
            } else {
                place.insert(branch, inner.len() as u32 | BRANCH);
                inner.push(branch);
            }
        }
        let moved = |s: &u32| if s & BRANCH == 0 { *s } else { place[s] };
        let slots = inner.iter().flat_map(|b| self.children(*b)).map(moved).collect();
        Blocks { slots, blocks, depth: self.depth }
    }

    pub(crate) fn apart<T: Stored>(&self) -> Apart<T> {
        let (mut nodes, mut leaves, mut branches) = (Vec::new(), Vec::new(), 1);
        for branch in self.by_level() {
            let mut node = Masked { branches, leaves: leaves.len() as u32, mask: 0 };
            for (child, slot) in self.children(branch).iter().enumerate() {
                if slot & BRANCH == 0 {
                    leaves.push(T::of(f32::from_bits(*slot)));
                } else {
                    node.mask |= 1 << child;
                    branches += 1;
                }
            }
            nodes.push(node);
        }
        Apart { nodes, leaves, depth: self.depth }
    }
}
