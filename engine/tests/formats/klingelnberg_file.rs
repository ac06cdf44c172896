//! A writer of curve and value files in every shape that instruments give them. It shares nothing
//! with the reader.

/// Layout of the titles of traces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// A line `Profil:` before its traces; twist traces with their own title.
    Blocks,
    /// `Profil:  Zahn-Nr.: 1a rechts / 480 Werte  / z= 2.1`
    OneLine,
    /// `TOPOGRAFIE: Zahn-Nr.: 26 /Profil:1 rechts / 480 Werte  / z= 3.5`
    Topography,
}

#[derive(Clone, Debug)]
pub struct Style {
    pub byte_order_mark: bool,
    pub latin1: bool,
    pub line_end: &'static str,
    pub separator: char,
    pub per_line: usize,
    pub english: bool,
    pub undefined: &'static str,
    pub leading_zero: bool,
    pub layout: Layout,
    /// `d=` instead of `x=` for leads.
    pub by_diameter: bool,
    pub blank_lines: usize,
}

impl Default for Style {
    fn default() -> Self {
        Style {
            byte_order_mark: true,
            latin1: false,
            line_end: "\r\n",
            separator: ':',
            per_line: 12,
            english: false,
            undefined: "-2147483.648",
            leading_zero: false,
            layout: Layout::Blocks,
            by_diameter: false,
            blank_lines: 1,
        }
    }
}

/// A trace to be written; `None` is an undefined point.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    pub tooth: String,
    pub left: bool,
    pub profile: bool,
    pub index: u32,
    /// z of a profile; roll length or diameter of a lead.
    pub section: f64,
    pub values: Vec<Option<f64>>,
}

pub struct Lines {
    style: Style,
    text: String,
}

impl Lines {
    pub fn new(style: &Style, kind: &str) -> Self {
        let mut lines = Lines { style: style.clone(), text: String::new() };
        lines.line(&format!("HEADER KS.{kind}.FILE"));
        lines.line("TYPE      STI                ! Gear data");
        lines.line("VERSION   10.0 /2            ! Version");
        lines.line(&format!("SEPARATOR {}                  ! Separator", style.separator));
        lines.line("UNITS     mm                 ! Units");
        lines.line("ANGLE     decimal            ! Angle");
        lines.line("PROFILE   diameter           ! Profile");
        lines.line(if style.english { "LANGUAGE  1 ENG" } else { "LANGUAGE  0 DEU              ! Language" });
        lines.line(&format!("UNDEFINED {}       ! Undefined", style.undefined));
        lines.line("FILTER LEAD:    F:S 2");
        lines.line("");
        lines
    }

    pub fn line(&mut self, line: &str) -> &mut Self {
        self.text.push_str(line);
        self.text.push_str(self.style.line_end);
        self
    }

    /// A header line; `:` in the fields becomes the separator.
    pub fn code(&mut self, code: u32, german: &str, english: &str, fields: &str) -> &mut Self {
        let label = if self.style.english { english } else { german };
        let separator = self.style.separator;
        let fields = fields.replace(':', &separator.to_string());
        self.line(&format!("  {code:<4}{separator}{label:.<40}{separator} {fields}          "))
    }

    /// The codes of a gear and its ranges; `sides` puts left and right in fields of their own.
    pub fn gear(&mut self, gear: &Gear, separate: bool) -> &mut Self {
        let (right, left) = if self.style.english { ("right-hand", "left-hand") } else { ("rechts", "links") };
        let hand = if gear.beta == 0.0 {
            ""
        } else if gear.right_hand {
            right
        } else {
            left
        };
        let kind = match (gear.internal, self.style.english) {
            (false, false) => "Außenverzahnung",
            (true, false) => "Innenverzahnung",
            (false, true) => "external",
            (true, true) => "internal",
        };
        let pair = |a: f64| if separate { format!("{a} : {a}") } else { format!("{a}      {a}") };
        self.code(1, "Protokolldaten für Zahnrad", "Data of gear", "");
        self.code(20, "Zahnrad-Daten", "Gear data", "links   rechts");
        self.code(21, "Normalmodul mn", "Normal module mn", &format!("{}::L- :R-", gear.module));
        self.code(22, "Zähnezahl z", "No. of teeth z", &format!("{}      {kind}", gear.teeth));
        self.code(23, "Schrägungswinkel ß [Grad]", "Helix angle [deg]", &format!("{}   {hand}", gear.beta));
        self.code(24, "Eingriffswinkel alpha [Grad]", "Pressure angle [deg]", &gear.alpha.to_string());
        self.code(25, "Profilverschiebungsfaktor x", "Profile shift x", gear.shift.to_string().trim_start_matches('0'));
        self.code(26, "Zahnbreite [mm]", "Face width [mm]", &gear.width.to_string());
        self.code(27, "Kopfkreisdurchmesser da", "Tip diameter da", &gear.tip.to_string());
        self.code(272, "Fußkreisdurchmesser", "Root diameter", &gear.root.to_string());
        for (code, value) in (41..=45).zip(gear.profile) {
            self.code(code, "Messbereich [mm]", "Range [mm]", &pair(value));
        }
        for (code, value) in [46, 48, 49].into_iter().zip(gear.circles) {
            self.code(code, "Flankenlinienmesskreis", "Lead circle", &pair(value));
        }
        for (code, value) in (61..=64).zip(gear.helix) {
            self.code(code, "Messanfang (unten)", "Range", &pair(value));
        }
        for (code, value) in [65, 68, 69].into_iter().zip(gear.heights) {
            self.code(code, "Lage des Profils", "Profile position", &pair(value));
        }
        self.code(82, "Winkelabw. links", "Angle left", "FHAL:7 : -7 : 0:   5.5516");
        self.code(89, "Winkelabw. links", "Angle left", "FHBL:11 : -11 : 0:   15");
        self.code(101, "Kugeltaster Ø [mm]", "Stylus [mm]", ".5 : (#5) :");
        self.code(164, "Seitendefinition", "Sides", "ZSDEF: 0");
        self.code(165, "Reference fHb", "Reference fHb", " 0-VDI / 1-DIN :R_FHB: 1 : L: + : R: -");
        self.code(178, "Vorzeichen Flankenlinie", "Sign of lead", "LVORZ: 1: DIN");
        self.code(179, "Bezugslaenge Flankenlinie", "Reference length", "BZGFL: 1: Z");
        self.code(180, "Bezugslaenge Profil", "Reference length", "BZGPR: 0: M1-M2");
        self.code(181, "Plusmaterial Fl.", "Plus material", "PLMFL: 0: 0: 1");
        self.code(182, "Plusmaterial Pr.", "Plus material", "PLMPR: 0: 1: 0");
        self.code(183, "Schnitt", "Section", "SCHNT: 1");
        self.code(9001, "Unbekannt", "Unknown", "was : immer")
    }

    pub fn traces(&mut self, traces: &[Trace]) -> &mut Self {
        let mut title = "";
        for trace in traces {
            let words = if self.style.english { ["Lead", "Profile"] } else { ["Flankenlinie", "Profil"] };
            let name = words[usize::from(trace.profile)];
            let side = match (trace.left, self.style.english) {
                (true, false) => "links",
                (false, false) => "rechts",
                (true, true) => "left",
                (false, true) => "right",
            };
            let letter = if trace.profile {
                "z"
            } else if self.style.by_diameter {
                "d"
            } else {
                "x"
            };
            let (label, unit) = if self.style.english { ("Tooth no.", "values") } else { ("Zahn-Nr.", "Werte") };
            let count = trace.values.len();
            let (tooth, index, section) = (&trace.tooth, trace.index, trace.section);
            let twist = tooth.ends_with(|c: char| c.is_ascii_lowercase());
            let head = match self.style.layout {
                Layout::Blocks if twist => {
                    let title = if self.style.english { "Twist" } else { "Verschränkung" };
                    format!("{title}: {label}: {tooth} /{name}:{index} {side} / {count}  {unit}  {letter}= {section}")
                }
                Layout::Blocks => {
                    if title != name {
                        self.line(&format!("{name}:"));
                        title = name;
                    }
                    format!("{label}: {tooth} {side} / {count}  {unit}  {letter}= {section}")
                }
                Layout::OneLine => format!("{name}:  {label}: {tooth} {side} / {count} {unit}  / {letter}= {section}"),
                Layout::Topography => {
                    format!(
                        "TOPOGRAFIE: {label}: {tooth} /{name}:{index} {side} / {count} {unit}  / {letter}= {section}"
                    )
                }
            };
            self.line(&head);
            self.values(&trace.values);
            for _ in 0..self.style.blank_lines {
                self.line("");
            }
        }
        self
    }

    pub fn values(&mut self, values: &[Option<f64>]) -> &mut Self {
        for chunk in values.chunks(self.style.per_line) {
            let words: Vec<String> = chunk.iter().map(|value| self.value(*value)).collect();
            self.line(&format!(" {}", words.join(" ")));
        }
        self
    }

    fn value(&self, value: Option<f64>) -> String {
        let Some(value) = value else { return format!("{:>12}", self.style.undefined) };
        let mut text = format!("{value:.3}");
        if !self.style.leading_zero && value.abs() < 1.0 && value != 0.0 {
            text = text.replacen("0.", ".", 1);
        }
        format!("{text:>12}")
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if self.style.byte_order_mark && !self.style.latin1 {
            bytes.extend([0xEF, 0xBB, 0xBF]);
        }
        if self.style.latin1 {
            bytes.extend(self.text.chars().map(|c| u8::try_from(u32::from(c)).expect("a character of Latin-1")));
        } else {
            bytes.extend(self.text.as_bytes());
        }
        bytes
    }
}

/// A gear and how it was measured; mm and degrees.
#[derive(Clone, Debug)]
pub struct Gear {
    pub teeth: i32,
    pub module: f64,
    pub beta: f64,
    pub right_hand: bool,
    pub alpha: f64,
    pub shift: f64,
    pub width: f64,
    pub tip: f64,
    pub root: f64,
    pub internal: bool,
    /// d_a, d_1, d_2, d_e, L_α.
    pub profile: [f64; 5],
    /// b_a, b_1, b_2, b_e.
    pub helix: [f64; 4],
    /// Middle, inner, outer.
    pub circles: [f64; 3],
    /// Middle, lower, upper.
    pub heights: [f64; 3],
}

impl Gear {
    /// The spur gear of the measured data.
    pub fn spur() -> Self {
        Gear {
            teeth: 52,
            module: 1.0,
            beta: 0.0,
            right_hand: true,
            alpha: 20.0,
            shift: 0.011,
            width: 15.0,
            tip: 54.0219,
            root: 49.5219,
            internal: false,
            profile: [50.156, 50.3, 54.022, 54.2, 5.552],
            helix: [0.0, 0.75, 14.25, 15.0],
            circles: [51.898, 51.0, 53.0],
            heights: [7.5, 1.0, 14.0],
        }
    }
}
