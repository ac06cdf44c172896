//! Readable names of terms.

/// A readable name: `u^2*v`, `T2(u)*T1(v)`, `B3(u)*B0(v)`, `R3,0(u,v)`; curves are written in x.
pub(super) fn label((i, j): (usize, usize), letter: Option<char>, surface: bool) -> String {
    if letter == Some('R') && surface {
        // a rational function of two parameters is no product
        return format!("R{i},{j}(u,v)");
    }
    let mut name = String::with_capacity(16);
    let mut factor = |power: usize, axis: &str| {
        if power == 0 && !matches!(letter, Some('B' | 'R')) {
            return;
        }
        if !name.is_empty() {
            name.push('*');
        }
        match letter {
            Some(letter) => {
                name.push(letter);
                push_number(&mut name, power);
                name.push('(');
                name.push_str(axis);
                name.push(')');
            }
            None => {
                name.push_str(axis);
                if power > 1 {
                    name.push('^');
                    push_number(&mut name, power);
                }
            }
        }
    };
    if surface {
        factor(i, "u");
        factor(j, "v");
    } else {
        factor(i, "x");
    }
    if name.is_empty() {
        name.push('1');
    }
    name
}

/// Appends a decimal number (labels are made for every fit: the formatting machinery would be half
/// their cost).
fn push_number(to: &mut String, number: usize) {
    if number >= 10 {
        push_number(to, number / 10);
    }
    to.push(char::from(b'0' + (number % 10) as u8));
}
