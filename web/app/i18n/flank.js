// Texts of the maps of flanks.

import de from "./de/flank.js";
import en from "./en/flank.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
