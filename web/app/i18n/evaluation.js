// Texts of evaluations.

import de from "./de/evaluation.js";
import en from "./en/evaluation.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
