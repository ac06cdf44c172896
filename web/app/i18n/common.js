// Texts common to several pages.

import de from "./de/common.js";
import en from "./en/common.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
