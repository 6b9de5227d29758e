//! Response maps of arbitrary words, queried anywhere: refused, or bounds in order.

use arbtest::arbitrary::Unstructured;
use model_core::energy::ResponseMap;
use model_core::energy::response_map::{
    Bounded, FARTHEST, Response, Spacing, detuning, fixed, level, number, row, row_distance, seal,
};

use super::change::{any, below};
use crate::fuzz;

const MAPS: [&[u8]; 3] = [
    include_bytes!("../../src/simulated_node/contact-separation.bin"),
    include_bytes!("../../src/simulated_node/bump-stop.bin"),
    include_bytes!("../../src/simulated_node/sliding.bin"),
];
/// Words of the head that say where the others lie.
const LAYOUT: usize = 28;

/// A number of any size, sign and kind, half of them within usual maps.
pub(super) fn real(bytes: &mut Unstructured<'_>) -> f32 {
    let usual = [0.2, 1.0, 3.7, 9.81, 19.9, 20.1, 21.0, 63.0];
    let extreme =
        [0.0, -0.0, f32::MIN_POSITIVE, 1e-45, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    match below(bytes, 4) {
        0 | 1 => usual[below(bytes, usual.len())] * (1.0 + f32::from(any::<i8>(bytes)) * 1e-3),
        2 => extreme[below(bytes, extreme.len())],
        _ => f32::from_bits(any(bytes)),
    }
}

fn judge(response: Response) {
    let in_order = |income: Bounded| {
        assert!(0.0 <= income.low && income.low <= income.value && income.value <= income.high, "{income:?}");
    };
    match response {
        Response::One { income, .. } => in_order(income),
        Response::Two { lower, upper } => [lower, upper].into_iter().for_each(in_order),
        Response::Outside(_) => {}
    }
    response.income().into_iter().for_each(in_order);
}

#[test]
fn maps() {
    fuzz("response maps", 6000, |bytes| {
        let image = MAPS[below(bytes, MAPS.len())];
        let words = image.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]]));
        let mut words: Vec<u16> = words.collect();
        let original = words.clone();
        for _ in 0..1 + below(bytes, 4) {
            // One of eight changes is in the head.
            let place = match below(bytes, 8) {
                0 => below(bytes, LAYOUT),
                _ => LAYOUT + below(bytes, words.len() - LAYOUT),
            };
            match below(bytes, 4) {
                0 => words[place] ^= 1 << below(bytes, 16),
                1 => words[place] = any(bytes),
                2 => words[place] = [0, 1, 0x7fff, 0x8000, 0xffff][below(bytes, 5)],
                _ => words[place] = words[place].wrapping_add(any::<i8>(bytes) as u16),
            }
        }
        if below(bytes, 16) == 0 {
            words.truncate(below(bytes, words.len()));
        }
        let fingerprint = words.get(3..5).map_or(0, |two| u32::from(two[0]) | u32::from(two[1]) << 16);
        // A change without that of the checksum is always refused.
        assert_eq!(ResponseMap::new(&words[..], fingerprint).is_ok(), words == original);
        seal(&mut words);
        let octets: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let of_octets = ResponseMap::new(&octets[..], fingerprint);
        let Ok(map) = ResponseMap::new(&words[..], fingerprint) else {
            assert!(of_octets.is_err());
            return false;
        };
        let of_octets = of_octets.expect("the same map");
        assert!(map.amplitudes().iter().all(|amplitude| amplitude.is_finite()));
        assert!(map.agreement().median.is_finite());
        for _ in 0..8 {
            let [amplitude, frequency, voltage] = [(); 3].map(|()| real(bytes));
            let slice = if any(bytes) { below(bytes, 3) } else { any(bytes) };
            assert!(map.voltage(slice).is_finite());
            judge(map.at(amplitude, frequency));
            judge(map.in_slice_at(slice, amplitude, frequency));
            let found = map.at_voltage(amplitude, frequency, voltage);
            judge(found);
            assert_eq!(of_octets.at_voltage(amplitude, frequency, voltage), found);
            let broadband = map.broadband(amplitude);
            assert!(broadband.is_none_or(|broadband| broadband.value >= 0.0), "{broadband:?}");
        }
        true
    });
}

#[test]
fn coordinates() {
    fuzz("coordinates of maps", 4000, |bytes| {
        let spacing = Spacing { shift: any(bytes), bits: any(bytes) };
        let _ = (row(any(bytes), spacing), row_distance(any(bytes), spacing));
        let shift = any(bytes);
        let units = fixed(real(bytes), shift);
        assert!(units.is_none_or(|units| units < 1 << 30), "{units:?}");
        let distance = any::<i32>(bytes);
        let _ = detuning(distance, any(bytes));
        let (near, slope) = (distance % (FARTHEST + 1).cast_signed(), any::<u32>(bytes) % (1 << 13));
        assert_eq!(detuning(-near, slope), -detuning(near, slope));
        let value = real(bytes);
        let level = level(value);
        assert_eq!(level.is_some(), value >= 0.0 && value.is_finite(), "{value}");
        assert!(level.is_none_or(|level| (0..1 << 19).contains(&level)));
        assert!(number(any(bytes)) > 0.0);
        true
    });
}
