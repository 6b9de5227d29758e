//! Changes of valid inputs: mild ones, which most readers take, and wild ones.

use arbtest::arbitrary::Unstructured;

/// Values that break readers, between semicolons.
const VALUES: &str = "0;-0.0;1;-1;2;1e308;-1e308;1e999;1e-308;nan;inf;-inf;true;false;\
    99999999999999999999999999999999999999999;0x7fffffffffffffff;-9223372036854775808;\"\";\
    \"sine\";[];{};[1, 2];1979-05-27;\"\\u0000\";1.;1_0;\"a\\nb\";\"\\u001b[31m\";time (min);=1+1";

/// Below `count`, which is not 0.
pub(super) fn below(bytes: &mut Unstructured<'_>, count: usize) -> usize {
    bytes.int_in_range(0..=count - 1).expect("zeros follow the last byte")
}

pub(super) fn one_of<'a, T: ?Sized>(bytes: &mut Unstructured<'_>, choices: &[&'a T]) -> &'a T {
    choices[below(bytes, choices.len())]
}

pub(super) fn any<T: for<'a> arbtest::arbitrary::Arbitrary<'a>>(bytes: &mut Unstructured<'_>) -> T {
    bytes.arbitrary().expect("zeros follow the last byte")
}

/// The places of the numbers in a line up to its comment, from the first byte of it that may be part of a value.
fn numbers(line: &[u8], from: usize) -> Vec<(usize, usize)> {
    let end = line.iter().position(|byte| *byte == b'#').unwrap_or(line.len());
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || b"+-._".contains(&byte);
    let (mut found, mut at) = (Vec::new(), from);
    while at < end {
        let length = line[at..end].iter().take_while(|byte| is_part(**byte)).count();
        let text = std::str::from_utf8(&line[at..at + length]).unwrap_or_default();
        if text.parse::<f64>().is_ok_and(f64::is_finite) {
            found.push((at, at + length));
        }
        at += length.max(1);
    }
    found
}

/// Another number near the one of this text, written in one of several ways.
fn near(bytes: &mut Unstructured<'_>, text: &str) -> String {
    let factor = [0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 2.0][below(bytes, 7)];
    let Ok(value) = text.parse::<f64>() else { return text.to_owned() };
    match (text.parse::<i64>().is_ok(), any::<u8>(bytes) % 3) {
        (true, _) => format!("{:.0}", value * factor),
        (_, 0) => format!("{:e}", value * factor),
        (_, 1) => format!("{:?}", value * factor),
        _ => format!("+{:E}", value * factor),
    }
}

/// The lines of a text, changed and joined.
fn in_lines(text: &mut Vec<u8>, change: impl FnOnce(&mut Vec<Vec<u8>>)) {
    let mut lines: Vec<Vec<u8>> = text.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    change(&mut lines);
    *text = lines.join(&b'\n');
}

/// Replaces a number of a random line by one near it. `after` is the byte after which values stand, if one does.
fn change_number(bytes: &mut Unstructured<'_>, text: &mut Vec<u8>, after: Option<u8>) {
    in_lines(text, |lines| {
        let line = below(bytes, lines.len());
        let line = &mut lines[line];
        let from = after.map_or(Some(0), |sign| line.iter().position(|byte| *byte == sign));
        let places = from.map(|from| numbers(line, from)).unwrap_or_default();
        if !places.is_empty() {
            // In a table mostly the last one, as the first ones are times.
            let is_last = after.is_none() && below(bytes, 8) > 0;
            let (start, end) = places[if is_last { places.len() - 1 } else { below(bytes, places.len()) }];
            let value = near(bytes, &String::from_utf8_lossy(&line[start..end]));
            line.splice(start..end, value.bytes());
        }
    });
}

/// Any change of bytes, lines and values.
fn wild(bytes: &mut Unstructured<'_>, text: &mut Vec<u8>, before: &[u8]) {
    if text.is_empty() {
        return;
    }
    let place = below(bytes, text.len());
    let end = (place + 1 + below(bytes, 12)).min(text.len());
    match below(bytes, 10) {
        // A value instead of another: what follows a sign up to the comment or the end of the cell.
        0..=3 => {
            let signs: Vec<usize> = (0..text.len()).filter(|&at| before.contains(&text[at])).collect();
            if !signs.is_empty() {
                let at = signs[below(bytes, signs.len())];
                let rest = text[at + 1..].iter().position(|byte| b"\n#,;\t}".contains(byte));
                let stop = rest.map_or(text.len(), |rest| at + 1 + rest);
                let value = one_of(bytes, &VALUES.split(';').collect::<Vec<_>>());
                text.splice(at + 1..stop, value.bytes());
            }
        }
        4 => in_lines(text, |lines| {
            let (one, other) = (below(bytes, lines.len()), below(bytes, lines.len()));
            match below(bytes, 3) {
                0 => lines.swap(one, other),
                1 => drop(lines.remove(one)),
                _ => lines.insert(other, lines[one].clone()),
            }
        }),
        5 => {
            let count = below(bytes, 3000);
            let piece = one_of(bytes, &["[", "{a=", "\"", "[[x]]\n", "\n", "9", "a.", ",", "\u{e9}"]);
            text.splice(place..place, piece.repeat(count).bytes());
        }
        6 => text[place] ^= 1 << below(bytes, 8),
        7 => text[place..end].fill_with(|| any(bytes)),
        8 => drop(text.drain(place..end)),
        _ => {
            let piece = text[place..end].to_vec();
            let at = below(bytes, text.len());
            text.splice(at..at, piece);
        }
    }
}

/// Changes a scene file. Of four texts one has wild changes; some are bytes.
pub(super) fn scene(bytes: &mut Unstructured<'_>, text: &[u8]) -> Vec<u8> {
    let mut text = text.to_vec();
    if below(bytes, 50) == 0 {
        return any(bytes);
    }
    for _ in 0..1 + below(bytes, 3) {
        match below(bytes, 6) {
            0..=2 => change_number(bytes, &mut text, Some(b'=')),
            3 => in_lines(&mut text, |lines| {
                let at = below(bytes, lines.len());
                lines.insert(at, one_of(bytes, &["", "# \u{b5}W", "\t", "#", "  # a = \"b"]).into());
            }),
            4 => in_lines(&mut text, |lines| {
                let at = below(bytes, lines.len());
                lines[at].extend(one_of(bytes, &[" ", "\t # end", " #", "\r"]).bytes());
            }),
            // Keys of one table have no order.
            _ => in_lines(&mut text, |lines| {
                let at = below(bytes, lines.len());
                let is_key =
                    |line: &Vec<u8>| line.contains(&b'=') && !line.contains(&b'[') && line[0] != b'#';
                if lines.get(at..at + 2).is_some_and(|two| two.iter().all(is_key)) {
                    lines.swap(at, at + 1);
                }
            }),
        }
    }
    if below(bytes, 4) == 0 {
        (0..1 + below(bytes, 2)).for_each(|_| wild(bytes, &mut text, b"="));
    }
    text
}

/// Changes a table of numbers. Of four texts one has wild changes.
pub(super) fn table(bytes: &mut Unstructured<'_>, text: &[u8]) -> Vec<u8> {
    let mut text = text.to_vec();
    for _ in 0..below(bytes, 3) {
        match below(bytes, 4) {
            0 | 1 => change_number(bytes, &mut text, None),
            2 => in_lines(&mut text, |lines| {
                let last = lines.len() - 1;
                drop(lines.remove(last.saturating_sub(1 + below(bytes, 4))));
            }),
            _ => in_lines(&mut text, |lines| {
                let ending = if below(bytes, 2) == 0 { "" } else { "\r" };
                lines.iter_mut().filter(|line| !line.is_empty()).for_each(|line| line.extend(ending.bytes()));
            }),
        }
    }
    if below(bytes, 4) == 0 {
        (0..1 + below(bytes, 2)).for_each(|_| wild(bytes, &mut text, b"\n,;\t"));
    }
    text
}

/// Changes an override `key=value` of a scene.
pub(super) fn set(bytes: &mut Unstructured<'_>, text: &str) -> String {
    let mut text = text.as_bytes().to_vec();
    change_number(bytes, &mut text, Some(b'='));
    if below(bytes, 6) == 0 {
        wild(bytes, &mut text, b"=");
    }
    String::from_utf8_lossy(&text).into_owned()
}

/// Changes bytes of an image: of four images three have one small change, the other one any.
pub(super) fn image(bytes: &mut Unstructured<'_>, image: &mut [u8]) {
    let is_mild = below(bytes, 4) > 0;
    for _ in 0..if is_mild { 1 } else { 1 + below(bytes, 6) } {
        let place = below(bytes, image.len());
        let length = (1 + below(bytes, 8)).min(image.len() - place);
        match if is_mild { 0 } else { below(bytes, 5) } {
            0 => image[place] ^= 1 << below(bytes, 8),
            1 => image[place] = any(bytes),
            2 => image[place..place + length].fill([0, 0xff, 0x7f, 0x80][below(bytes, 4)]),
            3 => image[place..place + length].fill_with(|| any(bytes)),
            _ => {
                let from = below(bytes, image.len() - length + 1);
                image.copy_within(from..from + length, place);
            }
        }
    }
}
