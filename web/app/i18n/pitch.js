// Texts of pitches and run-out.

import de from "./de/pitch.js";
import en from "./en/pitch.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
