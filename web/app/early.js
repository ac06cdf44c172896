// Sets theme and language before the first paint, so that nothing changes its colour afterwards.
(() => {
  try {
    const settings = JSON.parse(localStorage.getItem("flankfit.settings") ?? "{}");
    if (settings.theme === "light" || settings.theme === "dark")
      document.documentElement.dataset.theme = settings.theme;
    document.documentElement.lang = settings.language ?? (navigator.language.startsWith("de") ? "de" : "en");
  } catch {
    // without storage the system's theme stays
  }
})();
