// The margins of each printed page: job, date, page. CSS only allows this in a style sheet, and the
// job's name is data: it is written as a CSS string of escapes alone.

/** @param {string} text */
export function cssString(text) {
  const escaped = [...text].map((sign) => (/[A-Za-z0-9]/.test(sign) ? sign : `\\${code(sign)} `));
  return `"${escaped.join("")}"`;
}

/** Escapes a character for CSS; one that CSS does not support becomes the replacement character. @param {string} sign */
function code(sign) {
  const point = sign.codePointAt(0) ?? 0;
  return (point === 0 || (point >= 0xd800 && point <= 0xdfff) ? 0xfffd : point).toString(16);
}

/** The longest text of a box that stays on one line. */
const LONGEST = 70;

/** @param {string} text */
const short = (text) => (text.length > LONGEST ? `${text.slice(0, LONGEST - 1)}…` : text);

/** @param {{ job: string, date: string, page: string }} words `page`: before the number */
export function pageRules({ job, date, page }) {
  const box = "font: 8pt system-ui, sans-serif; color: #505c69;";
  return `@page {
    size: A4; margin: 18mm 15mm;
    @top-left { content: ${cssString(short(job))}; ${box} }
    @top-right { content: ${cssString(date)}; ${box} }
    @bottom-right { content: ${cssString(`${page} `)} counter(page) "/" counter(pages); ${box} }
  }`;
}

/** Adds the boxes until the returned function is called. @param {Parameters<typeof pageRules>[0]} words */
export function showBoxes(words) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(pageRules(words));
  document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet];
  return () => {
    document.adoptedStyleSheets = document.adoptedStyleSheets.filter((one) => one !== sheet);
  };
}
