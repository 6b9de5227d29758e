//! The findings in our own words.

use super::Mark;

/// A result that a paper states, as an assertion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Its number; a letter for what no parameters tried reproduce.
    pub number: &'static str,
    /// Where the paper states it.
    pub source: &'static str,
    pub statement: &'static str,
    /// The scenes that show it, and what is changed in them.
    pub scene: &'static str,
    /// The expected mark.
    pub mark: Mark,
    /// What to know of the mark; empty if nothing.
    pub note: &'static str,
}

const fn finding(
    number: &'static str,
    [source, statement, scene]: [&'static str; 3],
    mark: Mark,
    note: &'static str,
) -> Finding {
    Finding { number, source, statement, scene, mark, note }
}

/// The scenes of the second paper at 44 Hz and at 220 Hz.
const BOTH: &str = "bump-stop-paper; bump-stop-tip and its variants (220 Hz)";
const PAPER: &str = "bump-stop-paper and its variants";
const NEAR_RESONANCE: &str = "bump-stop-tip and its variants (220 Hz)";
/// The law with which findings 33 to 41 and 43 are measured.
const INFERRED: &str = "Only with the inferred force law.";

/// All findings: the second paper's from 1 to 20, the first paper's from 21 to 43, and what is not reproduced.
pub static FINDINGS: [Finding; 48] = [
    finding(
        "1",
        [
            "Mak 2010, figure 6(a)",
            "In each period the moving base brings the beam to the stop, with several hits.",
            BOTH,
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "2",
        ["Mak 2010, figure 6(a)", "The stop limits the displacement of the beam where it stands.", BOTH],
        Mark::Shown,
        "",
    ),
    finding(
        "3",
        [
            "Mak 2010, figure 6(b)",
            "The contact force pushes the beam back, and is zero while the gap is open.",
            PAPER,
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "4",
        [
            "Mak 2010, figure 7",
            "Beam and rod do not stay together during contact: they separate and meet many times.",
            BOTH,
        ],
        Mark::Shown,
        "At 44 Hz the beam chatters for half of each contact phase, then rests; the bound of 2/3 is chosen for that.",
    ),
    finding(
        "5",
        ["Mak 2010, figure 7", "During contact, beam and rod move by about 1e-7 m.", BOTH],
        Mark::Shown,
        "",
    ),
    finding(
        "5a",
        [
            "Mak 2010, section 2",
            "The rod goes on ringing after the beam has left it, which a massless spring cannot.",
            PAPER,
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "6",
        ["Mak 2010, section 3", "A contact is short beside the periods of the beam's first modes.", BOTH],
        Mark::Shown,
        "The bound is a tenth of the second period.",
    ),
    finding(
        "7",
        ["Mak 2010, figure 6(c)", "Impacts excite high modes, and the voltage has their frequencies.", BOTH],
        Mark::Shown,
        "",
    ),
    finding("8", ["Mak 2010, figure 8", "The voltage is lower during contact.", BOTH], Mark::Shown, ""),
    finding(
        "9",
        ["Mak 2010, figure 8", "Out of contact the voltage is that of the beam without a stop.", PAPER],
        Mark::Chosen,
        "Frequency and load are chosen for it; near the resonance it does not hold.",
    ),
    finding("10", ["Mak 2010, section 3", "Impacts lower the mean power.", BOTH], Mark::Shown, ""),
    finding(
        "11",
        ["Mak 2010, figure 9", "A stop at mid-span gives higher voltage peaks than a stop at the tip.", BOTH],
        Mark::Shown,
        "",
    ),
    finding(
        "12",
        ["Mak 2010, section 3", "A stop away from the tip costs less power.", BOTH],
        Mark::Shown,
        "",
    ),
    finding(
        "13",
        ["Mak 2010, figure 9", "With either stop the voltage is below that without one.", BOTH],
        Mark::Shown,
        "Of RMS values. At 44 Hz the peaks with a stop are above those without, by the ringing after release.",
    ),
    finding(
        "14",
        [
            "Mak 2010, figure 10(a)",
            "In contact with a stop at the tip the beam's curvature changes sign, as if clamped and pinned.",
            PAPER,
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "15",
        [
            "Mak 2010, figure 10(b)",
            "In contact the beam as a whole bends less with the stop at the tip.",
            PAPER,
        ],
        Mark::Chosen,
        "At 44 Hz only; at 220 Hz it bends more.",
    ),
    finding(
        "16",
        ["Mak 2010, section 3", "The generated charge follows the deflected shape of the beam.", PAPER],
        Mark::Shown,
        "With a full electrode it is proportional to the slope of the tip, by the equations.",
    ),
    finding(
        "17",
        ["Mak 2010, abstract", "A stop lowers the largest bending of the beam at its clamp.", NEAR_RESONANCE],
        Mark::Chosen,
        "At 220 Hz only, near the resonance; at 44 Hz a stop raises it. A premise of the paper.",
    ),
    finding(
        "18",
        [
            "Mak 2010, sections 3 and 4",
            "Results settle with enough modes and a small enough step.",
            "bump-stop-paper, -mid-span; modes and steps",
        ],
        Mark::Shown,
        "RMS voltage and mean force settle; the number of contacts does not.",
    ),
    finding(
        "19",
        [
            "Mak 2010, section 4",
            "Near the resonance the RMS voltage needs more modes.",
            "bump-stop-tip beside bump-stop-paper; modes",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "20",
        [
            "Mak 2010, figure 11",
            "The energy that a capacitor takes up in a given time compares the positions of the stop.",
            "bump-stop-paper-charging, and without a stop or with it at mid-span",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "21",
        [
            "Fu 2020, figure 3(a)",
            "The more charge, the smaller the vibration.",
            "sliding, 100 MΩ, 0 to 120 µC/m²",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "22",
        ["Fu 2020, figure 3(a)", "Charge moves the resonance to slightly lower frequencies.", "as 21"],
        Mark::Shown,
        "",
    ),
    finding(
        "23",
        [
            "Fu 2020, figure 3(b)",
            "Much charge gives a high voltage although the vibration is small.",
            "as 21",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "24",
        [
            "Fu 2020, section 2.3",
            "Charge acts on the vibration like damping: at the resonance, not beside it.",
            "as 21, and at 16 Hz",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "25",
        [
            "Fu 2020, figure 4",
            "With little charge the resistance hardly matters, and lowers the peak a little.",
            "sliding, 20 µC/m², 0 Ω to 10 GΩ",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "26",
        ["Fu 2020, figure 4(b)", "Over resistance the resonance falls, then rises by very little.", "as 25"],
        Mark::Shown,
        "",
    ),
    finding(
        "27",
        [
            "Fu 2020, figure 5",
            "With much charge the peak goes left and down with resistance, then right and further down.",
            "sliding, 120 µC/m²; 200 µC/m² at 0.8 g",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "28",
        [
            "Fu 2020, figure 6(b)",
            "At the largest resistances the resonance is above that of the short circuit.",
            "as 27",
        ],
        Mark::Shown,
        "Not at 20 µC/m².",
    ),
    finding(
        "29",
        [
            "Fu 2020, figure 6(c)",
            "Over resistance the amplitude first rises, then falls and levels out.",
            "as 27; friction coefficients swapped between the patches",
        ],
        Mark::Shown,
        "The rise is below 0.3 %: see a.",
    ),
    finding(
        "30",
        [
            "Fu 2020, figure 6(a)",
            "Frequency and amplitude of the peak draw a loop over resistance.",
            "sliding, 200 µC/m² at 0.8 g",
        ],
        Mark::Chosen,
        "As shipped, at 120 µC/m² and 0.36 g, the loop is thin.",
    ),
    finding(
        "31",
        [
            "Fu 2020, section 2.4",
            "Piezoelectric shunting differs: its resonance rises with resistance throughout.",
            "bump-stop-none, 6 modes, 1 Ω to 1 GΩ",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "32",
        [
            "Fu 2020, section 2.4",
            "With a shunt the amplitude is largest at short and at open circuit.",
            "as 31",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "33",
        [
            "Fu 2020, figure 8",
            "The more charge, the smaller the largest gap.",
            "contact-separation, 5 to 50 µC/m², 1 and 100 MΩ",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "34",
        ["Fu 2020, figure 8", "Charge moves the band with impacts to the left.", "as 33"],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "35",
        ["Fu 2020, figure 8", "Charge widens the band, the more the higher the resistance.", "as 33, 100 MΩ"],
        Mark::Shown,
        "Only with the inferred force law. At 1 MΩ: see b.",
    ),
    finding(
        "36",
        [
            "Fu 2020, section 3.3",
            "With more charge and with more resistance impacts begin at a lower frequency.",
            "as 33, and 10 MΩ",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "37",
        [
            "Fu 2020, figure 9(a)",
            "A slightly higher frequency brings the first impacts, with long free flights between.",
            "contact-separation, 50 µC/m², 100 MΩ",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "38",
        [
            "Fu 2020, figure 9(b)",
            "Near the upper edge impacts are frequent and strong; just above it there are none.",
            "as 37",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "39",
        [
            "Fu 2020, figure 10",
            "The motion is periodic before the band, irregular at its left, and periodic again.",
            "as 37; 18.8 Hz for 40 s",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "40",
        [
            "Fu 2020, figure 11(a)",
            "With little charge the resistance hardly changes band and gap.",
            "contact-separation, 5 µC/m², 1 to 100 MΩ",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "41",
        [
            "Fu 2020, figure 11(b), (c)",
            "With much charge resistance widens the band a little.",
            "contact-separation, 50 µC/m², 1 to 100 MΩ",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "42",
        [
            "Fu 2020, section 3.2",
            "The parasitic capacitance matters most at large resistance.",
            "contact-separation, law gap-field, 20.5 Hz, 0 and 1 pF",
        ],
        Mark::Shown,
        "",
    ),
    finding(
        "43",
        [
            "Fu 2020, section 1",
            "An earlier experiment with little charge saw no effect of the resistance on vibration.",
            "contact-separation, 5 µC/m², 1 to 100 MΩ",
        ],
        Mark::Shown,
        INFERRED,
    ),
    finding(
        "a",
        [
            "Fu 2020, figure 6(c)",
            "The first rise of the amplitude is seen on a full axis (1 %).",
            "sliding, 200 µC/m² at 0.8 g; swapped friction",
        ],
        Mark::NotShown,
        "The friction work falls by second order in the lag of the charge only.",
    ),
    finding(
        "b",
        [
            "Fu 2020, figure 8(a)",
            "Charge widens the band at 1 MΩ too, by more than 0.05 Hz.",
            "contact-separation, 5 and 50 µC/m², 1 MΩ",
        ],
        Mark::NotShown,
        "",
    ),
    finding(
        "c",
        [
            "Mak 2010, figure 8",
            "The voltage is maintained out of contact with 1 MΩ and the capacitance of the dimensions.",
            "bump-stop-paper and its variants, 1 MΩ",
        ],
        Mark::NotShown,
        "A tenth of the capacitance would be the circuit of 100 kΩ.",
    ),
    finding(
        "d",
        [
            "Mak 2010, figures 7 to 9",
            "The beam never rests, keeps its voltage out of contact, and peaks higher at mid-span.",
            "bump-stop-paper and its variants, gap 30 µm",
        ],
        Mark::NotShown,
        "",
    ),
];
