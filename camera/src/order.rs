//! The order of file names in which numbers count by their value: `frame2` before `frame10`.

use std::cmp::Ordering;

/// Compares two names piece by piece: runs of digits by value, everything else by its bytes.
///
/// Equal up to leading zeros, the plain byte order decides, so that the order is total.
pub fn natural(left: &[u8], right: &[u8]) -> Ordering {
    let (mut a, mut b) = (left, right);
    while !a.is_empty() && !b.is_empty() {
        let ((piece_a, rest_a), (piece_b, rest_b)) = (split_piece(a), split_piece(b));
        let order = compare_pieces(piece_a, piece_b);
        if order != Ordering::Equal {
            return order;
        }
        (a, b) = (rest_a, rest_b);
    }
    a.len().cmp(&b.len()).then_with(|| left.cmp(right))
}

/// The leading run of digits, or of bytes that are none, and the rest.
fn split_piece(name: &[u8]) -> (&[u8], &[u8]) {
    let digits = name[0].is_ascii_digit();
    let end = name.iter().position(|byte| byte.is_ascii_digit() != digits).unwrap_or(name.len());
    name.split_at(end)
}

fn compare_pieces(a: &[u8], b: &[u8]) -> Ordering {
    if !(a[0].is_ascii_digit() && b[0].is_ascii_digit()) {
        return a.cmp(b);
    }
    let (a, b) = (without_leading_zeros(a), without_leading_zeros(b));
    a.len().cmp(&b.len()).then_with(|| a.cmp(b))
}

fn without_leading_zeros(digits: &[u8]) -> &[u8] {
    let start = digits.iter().position(|&digit| digit != b'0').unwrap_or(digits.len());
    &digits[start..]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(names: &[&str]) -> Vec<String> {
        let mut names: Vec<String> = names.iter().map(|name| (*name).to_string()).collect();
        names.sort_by(|a, b| natural(a.as_bytes(), b.as_bytes()));
        names
    }

    #[test]
    fn numbers_count_by_their_value_and_text_by_its_bytes() {
        let names = [
            "f10.png",
            "f2.png",
            "f1.png",
            "b7",
            "f2a.png",
            "10",
            "9",
            "f",
            "f999999999999999999999999",
            "g",
        ];
        let expected = [
            "9",
            "10",
            "b7",
            "f",
            "f1.png",
            "f2.png",
            "f2a.png",
            "f10.png",
            "f999999999999999999999999",
            "g",
        ];
        assert_eq!(sorted(&names), expected);
    }

    #[test]
    fn leading_zeros_do_not_count_and_the_order_is_still_total() {
        assert_eq!(sorted(&["f010", "f9", "f11", "f10"]), ["f9", "f010", "f10", "f11"]);
        assert_ne!(natural(b"f01", b"f1"), Ordering::Equal);
    }

    #[test]
    fn the_order_is_antisymmetric_and_transitive_on_all_short_names() {
        let letters = [b"".as_slice(), b"0", b"1", b"2", b"a"];
        let mut names: Vec<Vec<u8>> = Vec::new();
        for a in letters {
            for b in letters {
                for c in letters {
                    names.push([a, b, c].concat());
                }
            }
        }
        names.sort_by(|a, b| natural(a, b));
        for (i, a) in names.iter().enumerate() {
            for b in &names[i..] {
                assert_ne!(natural(a, b), Ordering::Greater);
                assert_ne!(natural(b, a), Ordering::Less);
            }
        }
    }
}
