//! `armv6m.s` against the arithmetic of the host: the text is interpreted, instruction by instruction.

extern crate std;

use std::collections::HashMap;
use std::string::{String, ToString};
use std::vec::Vec;

const SOURCE: &str = include_str!("../arithmetic/src/armv6m.s");
const SIGN: u32 = 1 << 31;
/// Indices of registers.
const SP: usize = 13;
const RETURN: usize = usize::MAX;

/// An instruction with its operands.
struct Line {
    name: String,
    operands: Vec<String>,
    /// Where it branches to.
    target: Option<usize>,
}

struct Program {
    lines: Vec<Line>,
    functions: HashMap<String, usize>,
}

impl Program {
    fn new() -> Self {
        let mut lines = Vec::new();
        let mut functions = HashMap::new();
        // Numbers of labels with the place of the next instruction.
        let mut labels = Vec::new();
        let source = SOURCE.lines().map(|line| line.split('@').next().unwrap_or_default().trim().to_string());
        for line in &expanded(&source.collect::<Vec<_>>(), &mut HashMap::new()) {
            let mut line = line.trim();
            if let Some((label, rest)) = line.split_once(':') {
                if label.parse::<u32>().is_ok() {
                    labels.push((label.to_string(), lines.len()));
                } else {
                    functions.insert(label.to_string(), lines.len());
                }
                line = rest.trim();
            }
            if line.is_empty() || line.starts_with('.') {
                continue;
            }
            let (name, operands) = line.split_once(' ').expect("an operand");
            let operands = operands.replace(['{', '}', '[', ']'], "");
            let operands = operands.split(',').map(|operand| operand.trim().to_string()).collect();
            lines.push(Line { name: name.to_string(), operands, target: None });
        }
        for (place, line) in lines.iter_mut().enumerate() {
            let is_branch = line.name.starts_with('b') && !matches!(line.name.as_str(), "bl" | "bx" | "bics");
            if is_branch {
                let (label, way) = line.operands[0].split_at(line.operands[0].len() - 1);
                let mut found = labels.iter().filter(|(of, _)| of == label).map(|(_, to)| *to);
                line.target =
                    if way == "b" { found.rfind(|&to| to <= place) } else { found.find(|&to| to > place) };
                assert!(line.target.is_some(), "{label}{way}");
            }
        }
        Self { lines, functions }
    }
}

/// Macros with the names of their parameters and their lines.
type Macros = HashMap<String, (Vec<String>, Vec<String>)>;

/// The lines of a text with its macros and repetitions in full, a statement each.
fn expanded(lines: &[String], macros: &mut Macros) -> Vec<String> {
    let (mut found, mut rest) = (Vec::new(), lines.iter());
    while let Some(line) = rest.next() {
        let all = line.split([' ', ',']).filter(|word| !word.is_empty());
        let all: Vec<String> = all.map(str::to_string).collect();
        let name = all.first().map_or("", String::as_str);
        if name == ".macro" || name == ".rept" {
            let body =
                rest.by_ref().take_while(|line| !line.starts_with(".end")).cloned().collect::<Vec<_>>();
            if name == ".macro" {
                macros.insert(all[1].clone(), (all[2..].to_vec(), body));
            } else {
                let times = all[1].parse().expect("a number");
                found.extend((0..times).flat_map(|_| expanded(&body, macros)));
            }
        } else if let Some((parameters, body)) = macros.get(name).cloned() {
            let with = |line: &String| {
                let pairs = parameters.iter().zip(&all[1..]);
                pairs.fold(line.clone(), |line, (of, value)| line.replace(&std::format!("\\{of}"), value))
            };
            found.extend(expanded(&body.iter().map(with).collect::<Vec<_>>(), macros));
        } else {
            found.extend(line.split(';').map(str::to_string));
        }
    }
    found
}

/// A core in a call of a function.
#[derive(Default)]
struct Core {
    registers: [u32; 16],
    stack: Vec<u32>,
    /// Negative, zero, carry, overflow.
    flags: [bool; 4],
    count: u32,
}

fn register(name: &str) -> usize {
    match name {
        "sp" => SP,
        "lr" => 14,
        "pc" => 15,
        _ => name[1..].parse().expect("a register"),
    }
}

impl Core {
    fn value(&self, operand: &str) -> u32 {
        match operand.strip_prefix('#') {
            Some(number) => number.parse().expect("a number"),
            None => self.registers[register(operand)],
        }
    }

    fn keep(&mut self, to: usize, result: u32) {
        self.registers[to] = result;
        self.flags[..2].copy_from_slice(&[result & SIGN != 0, result == 0]);
    }

    fn add(&mut self, a: u32, b: u32, carry: bool) -> u32 {
        let wide = u64::from(a) + u64::from(b) + u64::from(carry);
        let result = wide as u32;
        self.flags[2] = wide >> 32 != 0;
        self.flags[3] = (a ^ result) & (b ^ result) & SIGN != 0;
        result
    }

    fn shift(&mut self, is_left: bool, value: u32, by: u32) -> u32 {
        let by = by & 255;
        if by == 0 {
            return value;
        }
        let wide = if is_left { u64::from(value) << by.min(40) } else { u64::from(value) << 8 >> by.min(40) };
        self.flags[2] = if is_left { wide >> 32 & 1 != 0 } else { wide >> 7 & 1 != 0 };
        if is_left { wide as u32 } else { (wide >> 8) as u32 }
    }

    fn is_met(&self, condition: &str) -> bool {
        let [negative, zero, carry, overflow] = self.flags;
        match condition {
            "" => true,
            "eq" => zero,
            "ne" => !zero,
            "hs" => carry,
            "cc" => !carry,
            "hi" => carry && !zero,
            "mi" => negative,
            "pl" => !negative,
            "ge" => negative == overflow,
            "lt" => negative != overflow,
            "gt" => negative == overflow && !zero,
            "le" => negative != overflow || zero,
            other => panic!("{other}"),
        }
    }

    /// Runs a function; the compiler's functions are those of the host.
    fn call(program: &Program, function: &str, a: u32, b: u32) -> (u32, u32) {
        let mut core = Self::default();
        (core.registers[0], core.registers[1]) = (a, b);
        let saved = [4, 5, 6, 7].map(|index| index as u32 * 0x0101_0101);
        core.registers[4..8].copy_from_slice(&saved);
        let mut at = program.functions[function];
        while at != RETURN {
            core.count += 1;
            at = core.step(&program.lines[at], at);
        }
        assert!(core.stack.is_empty() && core.registers[4..8] == saved, "{function}");
        (core.registers[0], core.count)
    }

    /// Carries an instruction out; the place of the next one.
    fn step(&mut self, line: &Line, at: usize) -> usize {
        let operands: Vec<&str> = line.operands.iter().map(String::as_str).collect();
        let to = if line.target.is_none() { register_or_zero(operands[0]) } else { 0 };
        // With two operands the first one is also the first number.
        let pair = |core: &Self| match operands[..] {
            [a, b] | [_, a, b] => (core.value(a), core.value(b)),
            _ => panic!("{operands:?}"),
        };
        match line.name.as_str() {
            "push" => operands.iter().rev().for_each(|name| self.stack.push(self.registers[register(name)])),
            "pop" => {
                for name in &operands {
                    self.registers[register(name)] = self.stack.pop().expect("pushed");
                }
                if operands.contains(&"pc") {
                    return RETURN;
                }
            }
            "bx" => return RETURN,
            "bl" => {
                let [a, b] = [0, 1].map(|index| f32::from_bits(self.registers[index]));
                let result = match operands[0] {
                    "__mulsf3" => a * b,
                    "__divsf3" => a / b,
                    _ => a + b,
                };
                self.registers[..4].copy_from_slice(&[result.to_bits(), 1, 2, 3]);
                self.registers[12] = 4;
            }
            "mov" => self.registers[to] = self.value(operands[1]),
            "movs" => {
                let value = self.value(operands[1]);
                self.keep(to, value);
            }
            "ldr" => {
                let offset = operands.get(2).map_or(0, |operand| self.value(operand) as usize / 4);
                self.registers[to] = self.stack[self.stack.len() - 1 - offset];
            }
            "add" if to == SP => {
                let words = self.value(operands[1]) as usize / 4;
                self.stack.truncate(self.stack.len() - words);
            }
            "uxtb" => self.registers[to] = self.value(operands[1]) & 0xff,
            "lsls" | "lsrs" => {
                let (value, by) = pair(self);
                let result = self.shift(line.name == "lsls", value, by);
                self.keep(to, result);
            }
            "adds" | "adcs" => {
                let (a, b) = pair(self);
                let carry = line.name == "adcs" && self.flags[2];
                let result = self.add(a, b, carry);
                self.keep(to, result);
            }
            "subs" | "sbcs" | "rsbs" | "cmp" => {
                let (a, b) = pair(self);
                let (a, b) = if line.name == "rsbs" { (b, a) } else { (a, b) };
                let carry = line.name != "sbcs" || self.flags[2];
                let result = self.add(a, !b, carry);
                let before = self.registers[to];
                self.keep(to, result);
                if line.name == "cmp" {
                    self.registers[to] = before;
                }
            }
            "eors" | "orrs" | "ands" | "bics" | "muls" => {
                let (a, b) = pair(self);
                let result = match line.name.as_str() {
                    "eors" => a ^ b,
                    "orrs" => a | b,
                    "ands" => a & b,
                    "bics" => a & !b,
                    _ => a.wrapping_mul(b),
                };
                self.keep(to, result);
            }
            branch => {
                let target = line.target.unwrap_or_else(|| panic!("{branch}"));
                if self.is_met(&branch[1..]) {
                    return target;
                }
            }
        }
        at + 1
    }
}

fn register_or_zero(name: &str) -> usize {
    if name.starts_with("__") { 0 } else { register(name) }
}

/// Pairs of numbers of all kinds: near to each other, with few bits, at the ends of the range.
fn pairs(count: u64) -> impl Iterator<Item = (u32, u32)> {
    const SPECIAL: [u32; 12] = [
        0,
        SIGN,
        1,
        0x7f_ffff,
        0x80_0000,
        0x7f7f_ffff,
        0x7f80_0000,
        0xff80_0000,
        0x7fc0_0000,
        0x3f80_0000,
        0x3f80_0001,
        0xbf7f_ffff,
    ];
    let mut seed = 1_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as u32
    };
    (0..count).map(move |index| {
        let mut number = || random() << 16 ^ random();
        let (a, b, choice) = (number(), number(), number());
        let special = |choice: u32| SPECIAL[choice as usize % SPECIAL.len()];
        let exponent = a >> 23 & 255;
        match index % 6 {
            0 => (a, b),
            1 => (a, a ^ b & 0x83ff_ffff),
            2 => (a, b & 0x807f_ffff | a & 0x7f80_0000),
            3 => (a & 0xffff_0000, b & 0xfff0_0000),
            4 => (a & 0xffff_c000, b & 0x807f_8000 | exponent.saturating_sub(choice % 30) << 23),
            _ => (if choice & 1 == 0 { special(choice >> 1) } else { a }, special(choice >> 8)),
        }
    })
}

#[test]
fn products_quotients_sums_and_comparisons_have_the_bits_of_the_host() {
    let program = Program::new();
    let same =
        |one: u32, two: u32| one == two || f32::from_bits(one).is_nan() && f32::from_bits(two).is_nan();
    for (a, b) in pairs(60_000) {
        let [of_a, of_b] = [a, b].map(f32::from_bits);
        for (function, expected) in [
            ("__aeabi_fmul", of_a * of_b),
            ("__aeabi_fdiv", of_a / of_b),
            ("__aeabi_fadd", of_a + of_b),
            ("__aeabi_fsub", of_a - of_b),
        ] {
            let (found, _) = Core::call(&program, function, a, b);
            assert!(same(found, expected.to_bits()), "{function} {a:#x} {b:#x} {found:#x}");
        }
        for (function, expected) in [
            ("__aeabi_fcmplt", of_a < of_b),
            ("__aeabi_fcmple", of_a <= of_b),
            ("__aeabi_fcmpgt", of_a > of_b),
            ("__aeabi_fcmpge", of_a >= of_b),
        ] {
            let (found, _) = Core::call(&program, function, a, b);
            assert_eq!(found, u32::from(expected), "{function} {a:#x} {b:#x}");
        }
    }
}

#[test]
fn operations_on_usual_numbers_take_few_instructions() {
    let program = Program::new();
    let usual: Vec<(u32, u32)> = pairs(6000)
        .filter(|(a, b)| [a, b].iter().all(|bits| (100..150).contains(&(*bits >> 23 & 255))))
        .collect();
    let most =
        [("__aeabi_fmul", 58.0), ("__aeabi_fdiv", 88.0), ("__aeabi_fadd", 58.0), ("__aeabi_fcmplt", 20.0)];
    for (function, most) in most {
        let counts = usual.iter().map(|&(a, b)| f64::from(Core::call(&program, function, a, b).1));
        let mean = counts.sum::<f64>() / usual.len() as f64;
        assert!(mean < most && mean > 0.5 * most, "{function} {mean}");
    }
}
