// Texts of what a job asks of its flanks, and of figures held against it.

import de from "./de/requirements.js";
import en from "./en/requirements.js";
import { texts } from "./i18n.js";

export const t = texts({ en, de });
