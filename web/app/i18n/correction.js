// Texts of corrections.

import de from "./de/correction.js";
import en from "./en/correction.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
