//! Letters of five by seven pixels and two below the line, for captions.

/// Width of a letter with the gap after it.
pub(crate) const ADVANCE: usize = 6;
/// Height of a letter.
pub(crate) const HEIGHT: usize = 9;

/// Letters side by side, each five columns and a gap; drawn here, so that they can be read here.
const SHEETS: [(&str, [&str; HEIGHT]); 4] = [
    (
        "abcdefghijklmL",
        [
            "      #               #         ##        #       #      #  #      ##         #     ",
            "      #               #        #  #       #                 #       #         #     ",
            " ###  ####   ###   ####  ###   #     #### ####   ##     ##  #  #    #   ## #  #     ",
            "    # #   # #   # #   # #   # ###   #   # #   #   #      #  # #     #   # # # #     ",
            " #### #   # #     #   # #####  #    #   # #   #   #      #  ##      #   # # # #     ",
            "#   # #   # #   # #   # #      #    #   # #   #   #      #  # #     #   # # # #     ",
            " #### ####   ###   ####  ###   #     #### #   #  ###     #  #  #   ###  # # # ##### ",
            "                                        #             #  #                          ",
            "                                     ###               ##                           ",
        ],
    ),
    (
        "nopqrstuvwxyz",
        [
            "                                    #                                         ",
            "                                    #                                         ",
            "# ##   ###  ####   #### # ##   #### ####  #   # #   # # # # #   # #   # ##### ",
            "##  # #   # #   # #   # ##  # #     #     #   # #   # # # #  # #  #   #    #  ",
            "#   # #   # #   # #   # #      ###  #     #   # #   # # # #   #   #   #   #   ",
            "#   # #   # #   # #   # #         # #   # #  ##  # #  # # #  # #  #   #  #    ",
            "#   #  ###  ####   #### #     ####   ###   ## #   #    # #  #   #  #### ##### ",
            "            #         #                                               #       ",
            "            #         #                                            ###        ",
        ],
    ),
    (
        "0123456789",
        [
            " ###    #    ###   ###     #  #####  ###  #####  ###   ###  ",
            "#   #  ##   #   # #   #   ##  #     #         # #   # #   # ",
            "#  ##   #       #     #  # #  ####  #        #  #   # #   # ",
            "# # #   #      #    ##  #  #      # ####    #    ###   #### ",
            "##  #   #     #       # #####     # #   #   #   #   #     # ",
            "#   #   #    #    #   #    #  #   # #   #   #   #   #     # ",
            " ###   ###  #####  ###     #   ###   ###    #    ###   ###  ",
            "                                                            ",
            "                                                            ",
        ],
    ),
    (
        ".,:-_/+=%()°",
        [
            "                                  #             ##       #   #     ##   ",
            "                                  #   #         ##  #   #     #   #  #  ",
            "             ##                  #    #   #####    #   #       #  #  #  ",
            "                  #####         #   #####         #    #       #   ##   ",
            "             ##                #      #   #####  #     #       #        ",
            " ##    ##                     #       #         #  ##   #     #         ",
            " ##    ##               ##### #                    ##    #   #          ",
            "        #                                                               ",
            "       #                                                                ",
        ],
    ),
];

/// Whether pixel (column, row) of a letter is set; a letter not drawn above is blank.
pub(crate) fn is_set(letter: char, column: usize, row: usize) -> bool {
    let find = |letter: char| {
        SHEETS.iter().find_map(|(letters, rows)| {
            letters.chars().position(|c| c == letter).map(|at| (at, rows))
        })
    };
    let found = find(letter).or_else(|| find(letter.to_ascii_lowercase()));
    found.is_some_and(|(at, rows)| {
        column + 1 < ADVANCE && rows[row].as_bytes().get(at * ADVANCE + column) == Some(&b'#')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_is_drawn_in_its_own_columns() {
        for (letters, rows) in SHEETS {
            for row in rows {
                assert_eq!(row.len(), letters.chars().count() * ADVANCE, "{letters}: {row:?}");
                let gaps = (ADVANCE - 1..row.len()).step_by(ADVANCE);
                assert!(gaps.into_iter().all(|k| row.as_bytes()[k] == b' '), "{letters}: {row:?}");
            }
            for letter in letters.chars() {
                let dots =
                    (0..HEIGHT * ADVANCE).filter(|k| is_set(letter, k % ADVANCE, k / ADVANCE));
                assert!(dots.count() >= 3, "{letter}");
            }
        }
    }
}
