//! Scene files and recordings of arbitrary content: an error of one line, or a scene that is sound.
//!
//! Most inputs are changed copies of valid files, because random bytes fail at the first of them. `HARVESTER_FUZZ`
//! multiplies the number of inputs.

use std::fs;
use std::path::{Path, PathBuf};

use harvester_scene::scene_file::{self, Excitation, Scene};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `count`.
    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn one_of<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.below(choices.len())]
    }
}

/// Values that break readers.
const VALUES: [&str; 26] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "1e308",
    "-1e308",
    "1e999",
    "1e-308",
    "nan",
    "inf",
    "-inf",
    "true",
    "false",
    "99999999999999999999999999999999999999999",
    "0x7fffffffffffffff",
    "-9223372036854775808",
    "\"\"",
    "\"sine\"",
    "[]",
    "{}",
    "[1, 2]",
    "1979-05-27",
    "\"\\u0000\"",
    "1.",
    "1_0",
];

/// Changes a text: values and lines of it, or any bytes.
fn mutate(random: &mut Random, text: &[u8]) -> Vec<u8> {
    let mut bytes = text.to_vec();
    for _ in 0..1 + random.below(3) {
        if bytes.is_empty() {
            return bytes;
        }
        let place = random.below(bytes.len());
        let end = (place + 1 + random.below(12)).min(bytes.len());
        match random.below(10) {
            // A value instead of another: what follows an equals sign up to the comment or the end of the line.
            0..=3 => {
                let signs: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at] == b'=').collect();
                if let Some(&at) = signs.get(random.below(signs.len())) {
                    let rest = bytes[at..].iter().position(|byte| matches!(byte, b'\n' | b'#' | b',' | b'}'));
                    let stop = rest.map_or(bytes.len(), |rest| at + rest);
                    let value = format!("= {} ", random.one_of(&VALUES));
                    bytes.splice(at..stop, value.bytes());
                }
            }
            4 | 5 => {
                let mut lines: Vec<Vec<u8>> =
                    bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
                let (one, other) = (random.below(lines.len()), random.below(lines.len()));
                match random.below(3) {
                    0 => lines.swap(one, other),
                    1 => drop(lines.remove(one)),
                    _ => lines.insert(other, lines[one].clone()),
                }
                bytes = lines.join(&b'\n');
            }
            6 => bytes[place] ^= 1 << random.below(8),
            7 => bytes[place..end].fill_with(|| random.next() as u8),
            8 => drop(bytes.drain(place..end)),
            _ => {
                let piece = bytes[place..end].to_vec();
                let at = random.below(bytes.len());
                bytes.splice(at..at, piece);
            }
        }
    }
    bytes
}

fn count(usual: usize) -> usize {
    let factor: Option<usize> = std::env::var("HARVESTER_FUZZ").ok().and_then(|text| text.parse().ok());
    usual * factor.unwrap_or(1)
}

/// A folder of one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Reads a scene. An error is one line; a scene is sound and the same if it is read again.
fn judge(file: &Path, what: &[u8]) -> Option<Scene> {
    let shown = || String::from_utf8_lossy(what).into_owned();
    match scene_file::read(file, &[]) {
        Ok(scene) => {
            let numbers = format!("{scene:?}");
            assert!(!numbers.contains("NaN"), "{numbers}\n{}", shown());
            assert!(scene.run.duration_s > 0.0 && scene.run.duration_s.is_finite(), "{}", shown());
            assert!((0.0..scene.run.duration_s).contains(&scene.run.settle_s), "{}", shown());
            if let Excitation::File(trace) = &scene.excitation {
                let samples = &trace.samples_m_per_s2;
                assert!(
                    samples.len() >= 2 && samples.iter().all(|sample| sample.abs() <= 1e5),
                    "{}",
                    shown()
                );
                assert!(trace.rate_hz > 0.0 && trace.rate_hz.is_finite(), "{}", shown());
            }
            assert!(scene_file::files(file, &[]).is_ok(), "{}", shown());
            assert_eq!(scene_file::read(file, &[]).as_ref(), Ok(&scene));
            Some(scene)
        }
        Err(error) => {
            let text = error.to_string();
            assert!(!text.is_empty() && !text.contains(['\n', '\r']), "{text:?}\n{}", shown());
            None
        }
    }
}

#[test]
fn changed_scene_files_are_refused_in_one_line_or_sound() {
    let folder = folder("arbitrary-scenes");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    fs::copy(shipped.join("noise.csv"), folder.join("noise.csv")).expect("a copy");
    let mut texts: Vec<Vec<u8>> = Vec::new();
    for entry in fs::read_dir(shipped).expect("the shipped scenes") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            texts.push(fs::read(path).expect("a scene"));
        }
    }
    texts.sort();
    let file = folder.join("scene.toml");
    let mut random = Random(11);
    let (mut accepted, all) = (0, count(3000));
    for number in 0..all {
        let bytes = mutate(&mut random, &texts[number % texts.len()]);
        fs::write(&file, &bytes).expect("a file");
        let Some(scene) = judge(&file, &bytes) else { continue };
        accepted += 1;
        // Comments and line ends mean nothing.
        let text = String::from_utf8(bytes).expect("accepted, so it is text");
        if !text.contains('\r') && !text.contains("\"\"\"") && !text.contains("'''") {
            let other = format!("\u{feff}# a comment\r\n{}\r\n# and one", text.replace('\n', "\r\n"));
            fs::write(&file, other).expect("a file");
            assert_eq!(scene_file::read(&file, &[]).as_ref(), Ok(&scene), "{text}");
        }
    }
    println!("{accepted} of {all} accepted");
    assert!(accepted > all / 20, "{accepted} of {all}");
}

#[test]
fn arbitrary_bytes_are_no_scene() {
    let file = folder("arbitrary-bytes").join("scene.toml");
    let mut random = Random(12);
    for _ in 0..count(300) {
        let bytes: Vec<u8> = (0..random.below(200)).map(|_| random.next() as u8).collect();
        fs::write(&file, &bytes).expect("a file");
        assert_eq!(judge(&file, &bytes), None);
    }
}

/// A scene that is shaken by a recording beside it.
fn shaken_by(random: &mut Random, recording: &str) -> String {
    let shipped = fs::read_to_string(scene_file::shipped("contact-separation")).expect("the shipped scene");
    let start = shipped.find("[excitation]").expect("the table is there");
    let lines = [
        random.one_of(&["", "", "column = 1", "column = 0", "column = 2", "column = \"x\"", "column = 1e18"]),
        random.one_of(&["", "", "rate_hz = 100.0", "rate_hz = 1000.0", "rate_hz = 48000"]),
        random.one_of(&["", "", "time_column = 1", "time_column = false", "time_column = \"t\""]),
        random.one_of(&["", "repeat = true", "repeat = true"]),
    ];
    let is_wave = recording.ends_with("wav");
    // Half of the scenes have keys that suit most recordings.
    let usual = ["column = 1", if is_wave { "" } else { "rate_hz = 100.0" }, "", "repeat = true"];
    let lines = if random.below(2) == 0 { usual } else { lines };
    let kept = lines.iter().filter(|line| !(is_wave && line.starts_with("time")));
    let more: Vec<&str> = kept.copied().collect();
    format!(
        "{}[excitation]\nkind = \"file\"\npath = \"{recording}\"\nscale_m_per_s2 = 1.0\n{}\n[run]\nduration_s = 0.02\n",
        &shipped[..start],
        more.join("\n")
    )
}

/// Writes a scene and its recording, and judges them; whether they were accepted.
fn judge_recording(random: &mut Random, folder: &Path, name: &str, recording: &[u8]) -> bool {
    let file = folder.join("scene.toml");
    fs::write(folder.join(name), recording).expect("a file");
    fs::write(&file, shaken_by(random, name)).expect("a file");
    judge(&file, recording).is_some()
}

#[test]
fn changed_tables_are_refused_in_one_line_or_sound() {
    let folder = folder("arbitrary-tables");
    let row = |n: u32| f64::from(n) * 0.01;
    let tables = [
        (0..30).map(|n| format!("{}\n", n % 7)).collect::<String>(),
        (0..30).map(|n| format!("{:.2},{}\n", row(n), n % 7)).collect(),
        (0..30)
            .fold("t;x\n".to_owned(), |text, n| text + &format!("{};{}\n", row(n), n % 5).replace('.', ",")),
        (0..30).fold("# a sensor\n\ntime_ms\tx\ty\n".to_owned(), |text, n| {
            text + &format!("{}\t1.5\t{n}\n", n * 10)
        }),
        (0..30).fold("\u{feff}\"t\",\"x\"\r\n".to_owned(), |text, n| {
            text + &format!("{:.2},\"{n}\"\r\n", row(n))
        }),
    ];
    let mut random = Random(13);
    let (mut accepted, all) = (0, count(3000));
    for number in 0..all {
        let table = &tables[number % tables.len()];
        let recording =
            if random.below(4) == 0 { table.clone().into() } else { mutate(&mut random, table.as_bytes()) };
        accepted += usize::from(judge_recording(&mut random, &folder, "table.csv", &recording));
    }
    println!("{accepted} of {all} accepted");
    assert!(accepted > all / 20, "{accepted} of {all}");
}

/// A WAV file: the format tag, channels, samples per second, bits, and its data.
fn wave(tag: u16, channels: u16, rate: u32, bits: u16, data: &[u8]) -> Vec<u8> {
    let align = channels.wrapping_mul(bits / 8);
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((36 + data.len() as u32).to_le_bytes());
    bytes.extend(b"WAVEfmt \x10\0\0\0");
    bytes.extend([tag, channels].iter().flat_map(|field| field.to_le_bytes()));
    bytes.extend([rate, rate.wrapping_mul(align.into())].iter().flat_map(|field| field.to_le_bytes()));
    bytes.extend([align, bits].iter().flat_map(|field| field.to_le_bytes()));
    bytes.extend(b"data");
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn changed_waves_are_refused_in_one_line_or_sound() {
    let folder = folder("arbitrary-waves");
    let data: Vec<u8> = (0..480_u32).map(|n| (n % 64) as u8).collect();
    let waves = [
        wave(1, 1, 1000, 16, &data),
        wave(1, 2, 48_000, 24, &data),
        wave(1, 1, 1000, 8, &data),
        wave(1, 3, 1000, 32, &data),
        wave(3, 1, 1000, 32, &data.iter().map(|byte| byte & 0x3f).collect::<Vec<u8>>()),
    ];
    let mut random = Random(14);
    let (mut accepted, all) = (0, count(4000));
    for number in 0..all {
        let mut recording = waves[number % waves.len()].clone();
        let header = 44;
        for _ in 0..random.below(4) {
            // The header counts: its fields are small numbers and extremes.
            let place = random.below(header);
            let value = [0, 1, 2, 3, 8, 16, 24, 32, 33, 64, 0x7f, 0x80, 0xfe, 0xff][random.below(14)];
            match random.below(4) {
                0 => recording[place] ^= 1 << random.below(8),
                1 => recording[place] = random.next() as u8,
                2 => recording[place] = value,
                _ => recording[20 + 2 * random.below(8)] = value,
            }
        }
        if random.below(8) == 0 {
            recording.truncate(random.below(recording.len()));
        }
        accepted += usize::from(judge_recording(&mut random, &folder, "wave.wav", &recording));
    }
    println!("{accepted} of {all} accepted");
    assert!(accepted > all / 20, "{accepted} of {all}");
}
