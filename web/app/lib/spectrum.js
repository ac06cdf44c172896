// The effect of regularisation on a spectrum.

/** Number of directions that are reduced by more than 0.5 %. @param {readonly number[]} factors shares that are kept */
export const reducedBy = (factors) => factors.filter((one) => one < 0.995).length;

/** Number of eigenvalues that are raised by more than 0.5 %. @param {readonly number[]} before @param {readonly number[]} [after] */
export const raisedIn = (before, after = before) =>
  reducedBy(before.map((value, i) => (value > 0 ? value / (after[i] ?? value) : 0)));
