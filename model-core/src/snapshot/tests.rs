use super::*;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Sample {
    numbers: [f64; 2],
    counts: [u16; 3],
    choice: Option<u32>,
    flags: [bool; 2],
}

snapshot_fields!(impl [] Sample { numbers, counts, choice, flags } if |sample| sample.counts[0] < 9);

const SAMPLE: Sample =
    Sample { numbers: [-0.0, 1.0e-310], counts: [1, 2, 65_535], choice: Some(7), flags: [true, false] };
const SIZE: usize = size_of::<Sample>();

fn snapshot() -> [u8; SIZE] {
    let mut bytes = [0; SIZE];
    assert_eq!(save(&SAMPLE, 99, &mut bytes), Ok(SIZE));
    bytes
}

#[test]
fn the_same_bits_come_back_and_what_follows_is_not_touched() {
    let mut flash = [0xff; SIZE + 5];
    assert_eq!(save(&SAMPLE, 99, &mut flash), Ok(SIZE));
    assert_eq!(flash[SIZE..], [0xff; 5]);
    let read = restore::<Sample>(99, &flash).expect("sound");
    assert_eq!(read, SAMPLE);
    assert_eq!(read.numbers.map(f64::to_bits), [-0.0_f64, 1.0e-310].map(f64::to_bits));
}

#[test]
fn every_flipped_bit_is_refused() {
    for bit in 0..SIZE * 8 {
        let mut bytes = snapshot();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let refused = restore::<Sample>(99, &bytes).expect_err("a bit is flipped");
        assert!(!matches!(refused, SnapshotError::NoState | SnapshotError::ForeignModel), "{bit}: {refused}");
    }
}

#[test]
fn too_little_room_and_too_few_bytes_are_named() {
    for given in 0..SIZE {
        let mut bytes = [0x55; SIZE];
        let room = bytes.get_mut(..given).expect("less");
        assert_eq!(save(&SAMPLE, 99, room), Err(SnapshotError::NoRoom { needed: SIZE, given }));
        assert_eq!(bytes, [0x55; SIZE]);
        let short = &snapshot()[..given];
        assert_eq!(restore::<Sample>(99, short), Err(SnapshotError::TooShort { needed: SIZE, given }));
    }
    let message = SnapshotError::NoRoom { needed: 80, given: 64 }.to_string();
    assert!(message.contains("80") && message.contains("64"));
}

/// Writes bytes that are no `Sample` as if they were one.
#[derive(Debug)]
struct Raw([u8; Sample::BYTES]);

snapshot_fields!(impl [] Raw { 0 });

#[test]
fn a_sound_snapshot_of_no_state_is_refused() {
    let payload = restore::<Raw>(99, &snapshot()).expect("bytes").0;
    let change = |place: usize, to: &[u8]| {
        let mut changed = payload;
        changed[place..place + to.len()].copy_from_slice(to);
        let mut bytes = snapshot();
        save(&Raw(changed), 99, &mut bytes).expect("room");
        restore::<Sample>(99, &bytes)
    };
    assert_eq!(change(0, &(-0.0_f64).to_le_bytes()), Ok(SAMPLE));
    for number in [f64::NAN, f64::INFINITY] {
        assert_eq!(change(8, &number.to_le_bytes()), Err(SnapshotError::NoState));
    }
    // A count that the condition of the sample refuses.
    assert_eq!(change(16, &[9]), Err(SnapshotError::NoState));
    // The flag of the choice, and the last truth value.
    for place in [22, Sample::BYTES - 1] {
        assert_eq!(change(place, &[2]), Err(SnapshotError::NoState));
    }
}

#[test]
fn another_model_state_or_version_is_foreign() {
    assert_eq!(restore::<Sample>(98, &snapshot()), Err(SnapshotError::ForeignModel));
    assert_eq!(restore::<[f64; 3]>(99, &snapshot()), Err(SnapshotError::ForeignModel));
    assert_eq!(restore::<Sample>(99, &[0xff; SIZE]), Err(SnapshotError::NotASnapshot));
    // Version 5 was that of 0.1.
    for version in [5, 7] {
        let mut other = snapshot();
        other[4] = version;
        let version = version.into();
        assert_eq!(restore::<Sample>(99, &other), Err(SnapshotError::ForeignVersion { version }));
    }
}
