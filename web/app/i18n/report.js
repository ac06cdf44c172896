// Texts of reports.

import de from "./de/report.js";
import en from "./en/report.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
