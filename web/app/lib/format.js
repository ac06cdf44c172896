// Numbers, times and counts as readers of a language write them. Pure functions of the language;
// `i18n/i18n.js` has those of the chosen language.

/** The sign for an absent value. */
export const ABSENT = "–";
const MINUS = "\u2212";
const NARROW = "\u202f";
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** Capitalises a text for the head of a chart or of an axis. @param {string} words */
export const capital = (words) => words.charAt(0).toUpperCase() + words.slice(1);

/** @typedef {"en" | "de"} Locale */
/** @typedef {number | null | undefined} Maybe */

/** The locale of dates. @param {Locale} locale */
const dateLocale = (locale) => (locale === "de" ? "de-DE" : "en-GB");

/** @param {Locale} locale */
export function formats(locale) {
  const comma = locale === "de" ? "," : ".";
  /** @param {string} digits as `toFixed` writes them */
  const local = (digits) =>
    (/[1-9]/.test(digits) ? digits.replace("-", MINUS) : digits.replace("-", "")).replace(".", comma);
  const counts = new Intl.NumberFormat(dateLocale(locale));
  const dates = new Intl.DateTimeFormat(dateLocale(locale), { dateStyle: "medium" });
  const times = new Intl.DateTimeFormat(dateLocale(locale), { dateStyle: "medium", timeStyle: "short" });
  const clock = new Intl.DateTimeFormat(dateLocale(locale), { timeStyle: "medium" });

  /** Formats with so many decimals. @param {Maybe} value @param {number} decimals */
  function fixed(value, decimals) {
    return isNumber(value) ? local(rounded(value, decimals)) : ABSENT;
  }

  /** Formats with so many significant digits; very large and very small numbers with a power of ten. @param {Maybe} value @param {number} digits */
  function significant(value, digits) {
    if (!isNumber(value)) return ABSENT;
    if (value === 0) return "0";
    const [mantissa = "0", power = "0"] = value.toExponential(digits - 1).split("e");
    const exponent = Number(power);
    if (exponent < -3 || exponent > Math.max(3, digits)) return `${local(mantissa)}·10${superscript(exponent)}`;
    return local(rounded(Number(`${mantissa}e${power}`), Math.max(0, digits - 1 - exponent)));
  }

  /**
   * Formats a value to the second digit of its standard error: `7.74 ± 0.52 µm/mm`.
   * @param {Maybe} value @param {Maybe} error @param {string} [unit]
   */
  function withError(value, error, unit) {
    // the sign of an angle is joined to its number
    const end = unit ? `${"′°".includes(unit) ? "" : NARROW}${unit}` : "";
    if (!isNumber(value)) return ABSENT;
    if (!isNumber(error) || !(error > 0)) return significant(value, 3) + end;
    const size = Math.max(exponentOf(value), exponentOf(error));
    const place = placeOf(error);
    if (size >= 5 || size < -3) {
      const scaled = [value, error].map((one) => local(rounded(one / 10 ** size, Math.max(0, size - place))));
      return `(${scaled.join(" ± ")})·10${superscript(size)}${end}`;
    }
    return `${local(rounded(value, -place))} ± ${local(rounded(error, -place))}${end}`;
  }

  /**
   * Formats a deviation: to the second digit of its standard error if there is one, else in µm to
   * one decimal, in mm to three, in other units to four digits. Without the unit.
   * @param {Maybe} value @param {string | undefined} unit @param {Maybe} [error]
   */
  function deviation(value, unit, error) {
    if (!isNumber(value)) return ABSENT;
    if (isNumber(error) && error > 0) return local(rounded(value, -placeOf(error)));
    if (unit === "µm") return fixed(value, 1);
    return unit === "mm" ? fixed(value, 3) : significant(value, 4);
  }

  /**
   * Formats a value of a scale or an axis: to a tenth of the leading digit of `size`, and at least
   * to 0.1 µm, in mm to 1 µm; in other units to four digits of `size`. Without the unit.
   * @param {Maybe} value @param {number} size the limit of the scale or the width of the axis @param {string | undefined} unit
   */
  function onScale(value, size, unit) {
    if (size > 0 && size < 1e-3) return significant(value, 3);
    const [least, digits] = unit === "µm" ? [1, 2] : unit === "mm" ? [3, 2] : [0, 4];
    const decimals = size > 0 ? digits - 1 - Math.floor(Math.log10(size)) : 0;
    return fixed(value, Math.max(least, decimals));
  }

  /**
   * Formats an interval, to the second digit of its standard error: `0.64 … 0.77`.
   * @param {readonly number[] | null | undefined} ends @param {Maybe} error @param {string} [unit]
   */
  function interval(ends, error, unit) {
    const [low, high] = ends ?? [];
    if (!isNumber(low) || !isNumber(high)) return ABSENT;
    const size = isNumber(error) && error > 0 ? error : (high - low) / 4;
    const place = size > 0 ? placeOf(size) : -3;
    const written = [low, high].map((end) => local(rounded(end, -place)));
    return written.join(" … ") + (unit ? `${NARROW}${unit}` : "");
  }

  /** @param {string | number | Date | null | undefined} time @param {Intl.DateTimeFormat} format */
  function dated(time, format) {
    const date = time === null || time === undefined ? undefined : new Date(time);
    return date && !Number.isNaN(date.getTime()) ? format.format(date) : ABSENT;
  }

  return {
    locale,
    fixed,
    significant,
    withError,
    deviation,
    onScale,
    interval,
    /** Micrometres: one decimal. @param {Maybe} value */
    um: (value) => fixed(value, 1),
    /** Millimetres: three decimals. @param {Maybe} value */
    mm: (value) => fixed(value, 3),
    /** λ*, eigenvalues, predicted errors: three digits. @param {Maybe} value */
    three: (value) => significant(value, 3),
    /** Condition numbers: two digits. @param {Maybe} value */
    condition: (value) => significant(value, 2),
    /** Whole numbers, grouped. @param {Maybe} value */
    count: (value) => (isNumber(value) ? counts.format(value) : ABSENT),
    /** @param {string | number | Date | null | undefined} time */
    date: (time) => dated(time, dates),
    /** @param {string | number | Date | null | undefined} time */
    time: (time) => dated(time, times),
    /** @param {string | number | Date | null | undefined} time */
    clock: (time) => dated(time, clock),
    /** Formats the initial text of a number field: all digits, the language's decimal sign. @param {Maybe} value */
    input: (value) => (isNumber(value) ? typed(value).replace(".", comma) : ""),
  };
}

/**
 * Reads a number with a decimal point or comma. Undefined for an empty text; NaN if it is not a
 * number.
 * @param {string} text @returns {number | undefined}
 */
export function parseNumber(text) {
  const plain = text.trim().replace(MINUS, "-").replace(",", ".");
  if (plain === "") return undefined;
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : Number.NaN;
}

/** Formats all digits; small numbers with a power of ten, which fields accept, too. @param {number} value */
function typed(value) {
  return value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential() : String(value);
}

/** @param {Maybe} value @returns {value is number} */
function isNumber(value) {
  return typeof value === "number" && Number.isFinite(value);
}

/** Returns the decimal place of an error's second digit, once it has been rounded to two. @param {number} error */
function placeOf(error) {
  return Number(error.toExponential(1).split("e")[1]) - 1;
}

/** @param {number} value */
function exponentOf(value) {
  return value === 0 ? Number.NEGATIVE_INFINITY : Math.floor(Math.log10(Math.abs(value)));
}

/** Rounds as `toFixed`, also to places before the decimal sign. @param {number} value @param {number} decimals */
function rounded(value, decimals) {
  if (decimals >= 0) return value.toFixed(Math.min(decimals, 100));
  const unit = 10 ** -decimals;
  return (Math.round(value / unit) * unit).toFixed(0);
}

/** Formats an exponent in superscript digits. @param {number} exponent */
export function superscript(exponent) {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPTS[Number(digit)]).join("");
  return exponent < 0 ? `⁻${digits}` : digits;
}
