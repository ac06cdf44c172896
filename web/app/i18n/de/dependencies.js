// A sentence about indistinguishable terms, from the data of a near dependency.

/** The number of terms that are named; the others are counted. */
const NAMED = 4;

/**
 * @param {readonly string[]} terms as they are written
 * @param {{ cosine?: string | undefined, rSquared?: string | undefined, index?: string | undefined }} figures
 * @param {"basis" | "nodes"} [cause]
 */
export default function sentence(terms, { cosine, rSquared, index }, cause = "nodes") {
  const of = [
    cosine && `Kosinus ${cosine}`,
    rSquared && `R² = ${rSquared}`,
    index && `Konditionsindex ${index}`,
  ].filter(Boolean);
  const told = of.length > 0 ? ` (${of.join(", ")})` : "";
  const [first = "", ...others] = terms;
  const where = cause === "basis" ? "in dieser Basis" : "über diesen Knoten";
  const end =
    cause === "basis"
      ? "In der Basis von Legendre entfällt das: Die Fläche und Größen aus ihr sind nicht betroffen."
      : "Deren Koeffizienten sind nicht zu unterscheiden.";
  if (others.length === 1) return `${first} und ${others[0]} verlaufen ${where} fast gleich${told}. ${end}`;
  const named = others.slice(0, NAMED - 1).join(", ");
  const more = others.length - (NAMED - 1);
  const rest = more > 0 ? ` und ${more === 1 ? "einem weiteren Term" : `${more} weiteren Termen`}` : "";
  return `${first} ist ${where} fast eine Linearkombination von ${named}${rest}${told}. ${end}`;
}
