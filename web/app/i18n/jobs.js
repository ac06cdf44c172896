// Texts of the list of jobs.

import de from "./de/jobs.js";
import en from "./en/jobs.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
