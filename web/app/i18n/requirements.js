// Texts of requirements, and of figures compared with them.

import de from "./de/requirements.js";
import en from "./en/requirements.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
