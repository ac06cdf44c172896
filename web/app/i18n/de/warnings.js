// German texts of the server's warnings by their codes. The server's own sentence, with the
// numbers, is shown below.

/** @type {Record<string, string>} */
export default {
  // fits
  attracted_entirely:
    "Kein Abstand zum Zielwert hebt sich vom Rauschen ab: Die Antwort ist der Zielwert selbst, ohne Gewicht.",
  design_range_assumed: "Die Auslegung nennt keinen Bereich für ihre Größen: angenommen sind die Auswertebereiche.",
  exceeds_double: "Einzelne Werte überschreiten den Bereich der Gleitkommazahlen und fehlen.",
  condition_unknown: "Die äußersten Eigenwerte sind noch nicht sicher bestimmt; die Kondition ist offen.",
  constraints_active:
    "Nebenbedingungen halten die Funktion fest: Standardabweichungen gelten mit ihnen, Intervalle ohne sie.",
  clustered_low_weights:
    "Knoten mit geringem Gewicht liegen beieinander: Dort folgt der Fit der Fläche nicht, und kein Intervall enthält den Abstand.",
  correlated_residuals:
    "Benachbarte Residuen hängen zusammen: Dem Modell fehlt etwas, oder die Standardabweichungen sind zu klein.",
  correlation_at_bound:
    "Die wahrscheinlichste Korrelation der Nachbarn liegt am Rand des durchsuchten Bereichs und ist keine Schätzung.",
  criterion_unavailable: "Das Kriterium braucht σ; stattdessen gelten die kleinsten Quadrate.",
  dependent_columns: "Bei einzelnen Stufen hängen die Spalten voneinander ab; dort fehlen Ergebnisse.",
  lambda_at_limit: "Das Kriterium hat im durchsuchten Bereich kein Minimum; die Antwort gilt am Ende des Bereichs.",
  discrepancy_not_reached: "Die Residuen bleiben immer unter dem Rauschen; die Antwort ist der größte Wert.",
  empty_spans: "In einzelnen Zellen liegen keine Knoten: Dort folgt die Fläche ihren Nachbarn.",
  exact_fit: "Viele Knoten liegen genau auf einer Fläche: Die Streuung ist 0, Standardabweichungen gibt es nicht.",
  few_digits: "Die übermittelten Zahlen bestimmen die Koeffizienten nur auf wenige Stellen.",
  filter_not_converged: "Das robuste Filter bewegte sich nach der letzten Runde noch; deren Ergebnis gilt.",
  filtered_columns_dependent:
    "Nach dem Filtern sind Spalten nicht mehr zu unterscheiden; Kondition, Korrelation und VIF danach fehlen.",
  filtered_columns_not_examined:
    "Bei so vielen Knoten wurden die Spalten nicht mitgefiltert; Kondition, Korrelation und VIF danach fehlen.",
  filtered_noise:
    "Ein Filter hat das Rauschen der Höhen verändert: σ, Standardfehler und λ* nehmen es als gemessen und unabhängig an.",
  filtering_raises_collinearity: "Das Filtern verringert die Unterschiede zwischen den Termen.",
  forgetting: "Ältere Messpunkte zählen weniger; Intervalle gelten, solange sich die Fläche nicht bewegt.",
  full_leverage: "Der Fit geht immer durch einzelne Knoten; ohne sie bestimmen die übrigen die Koeffizienten nicht.",
  group_variance_uncertain:
    "Die Varianz einer Gruppe beruht auf sehr wenigen Freiheitsgraden; Intervalle werden breit.",
  lack_of_fit:
    "Die Residuen haben eine systematische Form, die das Modell nicht enthält: Intervalle und Bänder berücksichtigen sie nicht. Einen höheren Grad wählen.",
  nodes_not_kept: "Die laufende Schätzung hält nur Summen; einzelne Residuen gibt es nach dem Abschluss.",
  no_corrected_error: "Für diesen Fit gibt es keinen korrigierten vorhergesagten Fehler.",
  no_degrees_of_freedom: "So viele Koeffizienten wie Knoten: Das Rauschen und Standardabweichungen sind unbekannt.",
  no_earlier_iterations:
    "Es gibt keine frühere Iteration dieser Flanke und dieses Zahns: Es gelten die kleinsten Quadrate.",
  no_enclosure: "Bewiesene Intervalle fehlen: Der Fit ist anderer Art, oder sie sind hier nicht zu beweisen.",
  no_influence: "Einflüsse einzelner Knoten fehlen bei diesem Fit.",
  no_lambda_curve: "Diese Regularisierung hat kein λ*, über dem eine Kurve liefe.",
  no_matrix_b: "Zu dieser Regularisierung gibt es keine Matrix B.",
  no_noise_without:
    "Ohne einzelne Knoten liegen alle anderen genau auf dem Fit: Ihre studentisierten Residuen und DFFITS fehlen.",
  no_noise: "Ohne Rauschen sind die kleinsten Quadrate genau; Randomisieren kann nichts verbessern.",
  no_prediction_intervals: "Wie weitere Höhen streuen, ist hier unbekannt; ihre Intervalle fehlen.",
  no_predictions: "Die Knoten bestimmen nicht jeden Koeffizienten; Höhen an anderen Orten sind beliebig unsicher.",
  no_regularized_perturbation: "Störungsschranken gibt es hier nur für die kleinsten Quadrate.",
  no_relative_error: "Alle Koeffizienten sind 0; einen relativen Fehler gibt es nicht.",
  no_representative: "Hier wird kein Eigenwert angehoben; für andere Messungen ist nichts zu übernehmen.",
  no_ridge_trace: "Einen Ridge-Verlauf gibt es nur bei Ridge.",
  no_scale: "Zu wenige Knoten liegen neben der Fläche; Streuung und Standardabweichungen fehlen.",
  no_shape: "Zu diesem Modell gibt es keine Form als Kurve oder Fläche.",
  no_standard_errors: "Standardabweichungen so vieler Koeffizienten sind zu aufwendig und fehlen.",
  norm_limit_contradicted: "Die Messpunkte widersprechen der Grenze der Norm: Intervalle und Schranken gelten nicht.",
  norm_limit_is_estimate:
    "Die Schranken der Verzerrung gelten nur für die geschätzte Norm der Koeffizienten; besser die Grenze angeben.",
  norm_limit_unused: "Die Grenze der Norm verkürzt die Intervalle dieses Fits nicht, nur die Schranken der Verzerrung.",
  not_converged: "Das Verfahren war am Ende seiner Schritte noch nicht fertig; die Antwort ist der letzte Stand.",
  not_unique: "Mehrere Lösungen sind gleich gut; die Antwort ist eine davon.",
  outside_domain: "Einzelne Orte liegen außerhalb des gemessenen Bereichs.",
  power_uncertain:
    "So wenige Freiheitsgrade bestimmen keinen Exponenten der Streuung: Intervalle am Rand und Bänder gelten seltener als angegeben.",
  perturbation_unbounded: "Die Unsicherheit der Knoten ist für die quadratische Schranke zu groß.",
  positions_as_exact: "Die Positionen der Knoten gelten als genau; die Intervalle zählen nur Fehler der Höhen.",
  positions_uncertain: "Die Positionen sind so unsicher, dass Intervalle seltener gelten können, als sie sagen.",
  post_selection: "Das Modell wurde nach denselben Knoten gewählt; Intervalle gelten seltener, als sie sagen.",
  prior_conflict: "Die Knoten widersprechen dem Vorwissen; es blieb außer Acht.",
  prior_noise_differs:
    "Das Rauschen dieser Knoten ist ein anderes als das früherer Iterationen: Aufspannung und Gewichte vergleichen.",
  prior_unused: "Ohne Rauschen ist das Vorwissen nicht abzuwägen; es blieb außer Acht. σ angeben.",
  rank_deficient: "Spalten hängen voneinander ab: Die Knoten bestimmen nicht alle Koeffizienten.",
  representative_misaligned:
    "Die Richtungen des repräsentativen Teils passen nicht zu diesen Knoten; ein großer Teil des Fehlers bleibt.",
  shape_at_bound: "Die geschätzte Form der Verteilung liegt am Rand; die Fehler sind wohl anders verteilt.",
  target_of_constant_unused: "Die Konstante wird nicht gedämpft; ihr Zielwert bleibt ohne Wirkung.",
  uncertainty_contradicted:
    "Die Residuen passen nicht zu den angegebenen Unsicherheiten von Positionen und Höhen; Einheiten prüfen.",
  uneven_variance:
    "Die Streuung hängt vom Ort ab: Intervalle sind dort zu schmal, wo sie größer ist. Mit variance „hc3“ fitten.",
  vif_infinite: "Einzelne Spalten hängen genau von anderen ab; einen VIF haben sie nicht.",
  worse_than_least_squares:
    "Diese Wahl lässt einen größeren Fehler erwarten als die kleinsten Quadrate; siehe die anderen Kriterien.",
  // traces, pitch and run-out
  correlated_noise:
    "Das Rauschen benachbarter Messpunkte hängt zusammen: Standardabweichungen und Konformität sind unsicher.",
  figures_not_determined: "Die Messpunkte bestimmen nicht alle Größen der Flanke.",
  foreign_reference_length: "Die Winkelabweichungen beziehen sich auf mehr Länge, als das Rad hat: keine Klassen.",
  helix_sign_doubtful: "Mit umgekehrten Flankenlinien passten die Linienzüge besser zusammen: Vorzeichen prüfen.",
  hole_in_trace: "Im Auswertebereich fehlt ein Stück des Linienzugs.",
  missing_teeth: "Es fehlen Zähne oder Lücken: Der Wert am ganzen Rad kann größer sein; ohne Klasse.",
  near_base_circle: "Der Auswertebereich beginnt nahe am Grundkreis, wo kleine Fehler des Durchmessers groß werden.",
  no_eccentricity: "Die Exzentrizität ist nicht zu bestimmen.",
  no_face_width: "Klassen der Flankenlinie brauchen die Zahnbreite des Rades.",
  no_mean_curve: "Die Messpunkte liegen an zu wenigen Stellen für eine mittlere Linie.",
  outliers_suspected: "Einzelne Messpunkte sind vermutlich grobe Fehler: Schmutz, ein Grat oder Messfehler.",
  outside_the_standard: "Das Rad liegt außerhalb des Geltungsbereichs der ISO 1328-1: keine Klassen.",
  pitches_do_not_close:
    "Die Einzelteilungsabweichungen ergaben um das Rad nicht 0; der Rest wurde gleichmäßig abgezogen.",
  range_not_covered: "Die Messpunkte decken den Bereich nicht ab, für den die Kenngrößen gelten.",
  samples_missing: "Im Auswertebereich fehlen Messpunkte.",
  slope_class_open: "Die Winkelabweichung hat keine Klasse: Die Lücke lässt sie offen.",
  sparse_samples: "Die Messpunkte liegen weit auseinander; Form- und Gesamtabweichung können größer sein.",
  surface_misfit: "Die Linienzüge passen zu keiner gemeinsamen Fläche: Vorzeichen, Schnitte und Zähne prüfen.",
  too_few_samples: "Zu wenige Messpunkte im Auswertebereich für eine Auswertung.",
  undefined_samples: "Messpunkte ohne Wert blieben außer Acht.",
  // curves and surfaces
  area_uncertain: "Der Flächeninhalt ist nur ungenau bestimmt.",
  figure_left_out: "Eine Kenngröße fehlt, weil sie sich nicht berechnen lässt.",
  length_uncertain: "Die Längen sind nur ungenau bestimmt.",
  no_curvature: "An einigen Stellen hat die Kurve keine Krümmung, weil ihre erste Ableitung 0 ist.",
  no_tangent_plane: "An einigen Stellen hat die Fläche keine Krümmung.",
  overshoot: "Zwischen zwei Punkten verlässt die Kurve deren Bereich.",
  swings_out: "Die Kurve schwingt zwischen den Punkten weit aus.",
  // gears and grids
  below_form_diameter: "Orte liegen unter dem Fuß-Formkreis, wo keine Evolvente mehr ist.",
  outside_face_width: "Die Orte reichen weiter, als das Rad breit ist.",
  above_tip: "Orte liegen über dem Kopf-Formkreis, wo kein Werkstoff ist.",
  few_teeth: "Für so wenige Zähne hat ISO 1328-1 keine Toleranzen.",
  internal_root: "Ein Zahnstangenwerkzeug schneidet kein Hohlrad: Der Fuß wird als Bogen angenommen.",
  no_fillet: "Kein Zahnstangenwerkzeug erreicht diesen Fußkreis: Die Flanke geht ohne Ausrundung hinab.",
  pointed_tip: "Die Flanken treffen sich vor dem Kopfkreis: Der Zahn ist spitz.",
  protuberance: "Die Protuberanz schneidet die Evolvente am Fuß weg.",
  root_above_tool: "Das Werkzeug schneidet tiefer als der angegebene Fußkreis.",
  root_below_tool: "Das Werkzeug erreicht den angegebenen Fußkreis nicht.",
  root_radius_reduced: "Die Lücke fasst nur einen kleineren Fußbogen.",
  thin_tip: "Der Zahnkopf ist sehr dünn.",
  tip_below_base_circle: "Der Kopfkreis liegt innerhalb des Grundkreises, wo die Evolvente endet.",
  tip_below_form_diameter: "Vom Zahn bleibt keine Evolvente.",
  tool_assumed: "Ohne Angabe eines Werkzeugs wird ein Zahnstangenprofil angenommen.",
  undercut: "Unterschnitt: Die Profilverschiebung ist zu klein.",
  // registrations and corrections
  axial_shift_by_modification:
    "Die axiale Verschiebung ist allein durch die Modifikationen bestimmt; Abweichungen gleicher Form tun dasselbe.",
  axial_shift_for_rotation: "Die axiale Verschiebung wirkt hier wie eine Drehung, die nicht frei ist.",
  not_over_roll_lengths: "Über den Wälzlängen gelingt die Anpassung nicht; die Kenngrößen fehlen.",
  coefficients_over_diameters:
    "Kenngrößen gelten über der Wälzlänge; für sie sind Koeffizienten über Durchmessern nicht bekannt: u als Wälzlänge senden.",
  dependent_settings: "Einige Einstellungen wirken hier genau gleich: Die Antwort sind die kleinsten Änderungen.",
  flanks_ambiguous: "Die Punkte passen etwa ebenso gut auf andere Flanken: Flanken angeben.",
  flanks_reassigned: "Punkte wurden einer anderen als der anfangs nächsten Flanke zugeordnet.",
  limits_not_settled:
    "Welche Einstellungen an ihrer Grenze bleiben, ist nicht eindeutig: Es gilt die beste gefundene Wahl.",
  flank_not_measured:
    "Eine Flanke wurde seit der letzten Korrektur nicht gemessen: Was gemeinsame Einstellungen an ihr bewirken, ist nicht bekannt.",
  limits_without_effect: "Die Messung sagt nichts über diese Einstellung; ihre Grenzen blieben ohne Wirkung.",
  motions_indistinguishable: "Diese Punkte unterscheiden einige Bewegungen nicht.",
  nodes_lost: "Einzelne Knoten haben nach dem Zurückdrehen keinen Ort auf der Flanke.",
  one_tooth: "Nur ein Zahn wurde gemessen: Die Streuung zwischen den Zähnen ist nicht bekannt.",
  points_outside_flank: "Punkte liegen jenseits von Kopf- oder Fußkreis.",
  points_misfit: "Einzelne Punkte liegen weit ab: Schmutz, eine andere Flanke oder ein Messfehler.",
  poor_fit:
    "Nach dem Ausrichten bleiben größere Abweichungen als an Flanken üblich: Bewegungen, Flanken und Rad prüfen.",
  registration_not_converged: "Das Ausrichten war am Ende seiner Schritte noch nicht fertig.",
  rotation_modulo_pitch: "Kein Punkt nennt seinen Zahn: Die Drehung gilt bis auf ganze Teilungen.",
  predicted_outside_limits: "Auch nach dieser Korrektur lägen Kenngrößen außerhalb ihrer Grenzen.",
  settings_limited: "Einzelne Einstellungen sind an ihrer Grenze; die übrigen gleichen aus, so weit sie können.",
  target_removes_crowning:
    "Die Korrektur zielt auf die unmodifizierte Flanke und nimmt Balligkeit oder Verschränkung weg: Auslegung oder Grenzen im Auftrag angeben.",
  teeth_contradict: "Punkte liegen auf einem anderen Zahn als angegeben.",
  undamped_correction: "Ungedämpft kann eine solche Korrektur bei Wiederholung die Einstellungen weit wegführen.",
  undetermined_settings: "Diese Messung sagt nichts über einzelne Einstellungen; sie bleiben, wie sie sind.",
  undetermined_settings_moved:
    "Die Messung sagt nichts über diese Einstellung, doch ihre Grenzen verlangen eine Änderung.",
  // streams
  fewer_nodes_than_coefficients: "Noch weniger Knoten als Koeffizienten.",
  too_few_nodes: "Zu wenige Knoten für Intervalle bei diesem Schätzer.",
  // figures of fits, requirements
  axes_unknown: "Keine Kenngrößen: Die Achsen sagen nicht, was gemessen ist.",
  no_extent: "Keine Kenngrößen: Die Messpunkte erstrecken sich nicht über die Flanke.",
  axes_missing:
    "Keine Kenngrößen: Was die Achsen bedeuten, ist nicht angegeben. Es lässt sich bei der Iteration ergänzen.",
  flank_missing:
    "Keine Kenngrößen: Welche Flanke gemessen ist, ist nicht angegeben. Es lässt sich bei der Iteration ergänzen.",
  gear_missing: "Keine Kenngrößen: Der Auftrag hat kein Zahnrad.",
  implausible_unit: "Die Einheiten sind unplausibel: Bei der Iteration berichtigen oder bestätigen.",
  no_involute: "Keine Kenngrößen: Einzelne Messpunkte liegen, wo das Rad keine Evolvente hat.",
  not_second_order:
    "Keine Kenngrößen: Das Modell ist keine Fläche, die sich durch eine zweiter Ordnung beschreiben lässt.",
  requirement_left_aside:
    "Eine Anforderung des Auftrags ist auf diese Auswertung nicht anwendbar und bleibt unberücksichtigt.",
  traces_with_own_zeros:
    "Keine Kenngrößen: Jede Kurve hat ihren eigenen Nullpunkt; ihre Auswertung nennt, was sie hat.",
  own_zeros_assumed:
    "Die Kurven treffen sich nicht: Für jede ist ein eigener Nullpunkt angenommen, der abgezogen wird.",
  // files
  gear_differs: "Das Zahnrad der Datei weicht vom Zahnrad des Auftrags ab.",
  hand_assumed: "Die Steigungsrichtung ist nicht angegeben: Rechtssteigend ist angenommen.",
  impossible_gear: "Die Daten eines Zahnrads der Datei passen nicht zusammen.",
  not_evaluated: "Die Kurven der Datei sind nicht ausgewertet.",
  column_ignored: "Eine Spalte der Tabelle wird nicht gelesen.",
  columns_unknown: "Welche Spalten der Tabelle Orte und Höhen sind, ist nicht bekannt.",
  flank_unknown:
    "Ein Wort in der Spalte der Flanken bezeichnet keine Flanke: Eine linke heißt links, linke, left, l oder lf, eine rechte rechts, rechte, right, r oder rf.",
  helices_turned: "Flankenlinien zählen anders herum als die Profile, die sie kreuzen; ihr Vorzeichen wird umgekehrt.",
  lines_left_out: "Zeilen vor der Tabelle werden ausgelassen.",
  too_many_flanks: "Die Tabelle hat Knoten von zu vielen Flanken; bitte Teile davon senden.",
  meaning_assumed: "Keine Kopfzeile nennt die Spalten; was sie enthalten, ist angenommen.",
  unit_assumed: "Eine Spalte der Tabelle nennt keine Einheit; die übliche ist angenommen.",
  off_the_tooth: "Punkte der Datei liegen nicht auf dem Zahn.",
  pitch_not_evaluated: "Die Teilungen der Datei sind nicht ausgewertet.",
  pitch_not_read: "Eine Teilungstabelle der Datei ist nicht zu lesen.",
  pitch_repeated: "Eine Flanke hat eine zweite Teilungstabelle; die erste gilt.",
  counting_contradicted: "Zählrichtung und Rundlauf der Datei widersprechen einander.",
  plus_material_assumed: "Die Plusmaterial-Regel der Datei ist nicht bekannt; sie ist angenommen.",
  pitch_sign_assumed: "Die Zählrichtung der Zähne steht nicht in der Datei; sie ist angenommen oder aus dem Rundlauf.",
  pitch_without_flank: "Kein Titel sagt, von welcher Flanke diese Teilungen sind.",
  sign_assumed: "Das Vorzeichen von Abweichungen ergibt sich nicht aus der Datei; es ist angenommen.",
  stray_point: "Ein Punkt der Datei gehört zu keiner Flanke.",
  trace_without_positions: "Eine Kurve der Datei hat keine Orte und bleibt weg.",
  unknown_tooth: "Eine Kurve nennt einen Zahn, den das Rad nicht hat.",
  // pitches, sections
  no_runout: "Kein Rundlauf: Die Teilungen lassen ihn nicht erkennen.",
  coincident: "Ein Teil der Fläche liegt in der Schnittebene; er gehört zu keiner Schnittkurve.",
  unresolved:
    "Stellenweise ist die Fläche zu flach, oder Zweige liegen zu nah beieinander: Schnittkurven können dort enden oder fehlen.",
  tolerance_not_met: "Die verlangte Toleranz ist nicht erreicht.",
};
