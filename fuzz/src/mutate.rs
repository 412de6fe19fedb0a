//! Damaged copies of files, always the same ones for the same seed.

/// SplitMix64. [Steele, Lea, Flood 2014]
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// One of 0 to `count` − 1; 0 of none.
    fn below(&mut self, count: usize) -> usize {
        (self.bits() % count.max(1) as u64) as usize
    }
}

/// What stands in place of a number or a word.
const WORDS: [&[u8]; 12] = [
    b"0",
    b"-1",
    b"1e400",
    b"nan",
    b"",
    b"4294967296",
    b"1e-320",
    b"90",
    b"\xff\xfe",
    b"\0",
    b"-0",
    b"9999999999999999999",
];

/// A copy of `bytes` with one to four changes; `other` is what parts are taken from, too.
pub fn damaged(bytes: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut copy = bytes.to_vec();
    for _ in 0..1 + random.below(4) {
        change(&mut copy, other, random);
    }
    copy
}

fn change(copy: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let at = random.below(copy.len());
    let scale = random.below(9);
    let end = copy.len().min(at + 1 + random.below(1 << scale));
    match random.below(8) {
        0 => copy.truncate(at),
        1 => drop(copy.drain(at..end)),
        2 => {
            let part = copy[at..end].to_vec();
            drop(copy.splice(at..at, part));
        }
        3 => {
            let start = random.below(other.len());
            let part = &other[start..other.len().min(start + end - at)];
            drop(copy.splice(at..end, part.iter().copied()));
        }
        4 | 5 => {
            let (start, end) = word(copy, at);
            drop(copy.splice(start..end, WORDS[random.below(WORDS.len())].iter().copied()));
        }
        6 => copy[at..end].fill([0, 0xff, 0x7f, 0x80][random.below(4)]),
        _ if at < copy.len() => copy[at] ^= 1 << random.below(8),
        _ => {}
    }
}

/// Where the word around `at` starts and ends.
fn word(bytes: &[u8], at: usize) -> (usize, usize) {
    let part = |b: &u8| b.is_ascii_alphanumeric() || b".+-".contains(b);
    let before = bytes[..at].iter().rev().take_while(|b| part(b)).count();
    let after = bytes[at..].iter().take_while(|b| part(b)).count();
    (at - before, at + after)
}
