<?php
// Import our files into Moodle, answer the questions, and print the results as JSON: `php moodle.php < request.json`, called
// by moodle.py.
//
// The request: `config` (path of Moodle's config.php), `xml`, `quiz` and `gradebook` (files to import, or null), `students`,
// and `answers`: by the name of a question, the answers to give, each with the language that sets the decimal sign.

require(__DIR__ . '/import.php');
require_once($CFG->dirroot . '/user/lib.php');
require_once($CFG->libdir . '/csvlib.class.php');
require_once($CFG->libdir . '/gradelib.php');
require_once($CFG->dirroot . '/grade/lib.php');
require_once($CFG->dirroot . '/grade/import/lib.php');

// Return the stored questions of a bank by name, without the parts that are embedded in them.
function load_questions(context $context): array {
    global $DB;
    $sql = 'SELECT q.name, q.id, e.idnumber, q.qtype, q.defaultmark, q.questiontext, q.generalfeedback, c.name AS category
              FROM {question} q
              JOIN {question_versions} v ON v.questionid = q.id
              JOIN {question_bank_entries} e ON e.id = v.questionbankentryid
              JOIN {question_categories} c ON c.id = e.questioncategoryid
             WHERE c.contextid = ? AND q.parent = 0';
    return array_map(fn($row) => (array) $row, $DB->get_records_sql($sql, [$context->id]));
}

// Return the form data that a browser would send for an answer. `chosen` are indices in the order of our file.
function make_form_data(question_attempt $attempt, array $answer): array {
    $question = $attempt->get_question();
    $start = $attempt->get_step(0);
    switch ($question->get_type_name()) {
        case 'numerical':
            return ['answer' => $answer['numbers'][0]];
        case 'essay':
            return ['answer' => $answer['text'], 'answerformat' => FORMAT_PLAIN];
        case 'multianswer':
            $data = [];
            foreach ($answer['numbers'] as $index => $number) {
                $data['sub' . ($index + 1) . '_answer'] = $number;
            }
            return $data;
        case 'truefalse':
            return $answer['chosen'] ? ['answer' => $answer['chosen'][0] === 0 ? 1 : 0] : [];
        case 'match':
            $shown = explode(',', $start->get_qt_var('_choiceorder'));
            $data = [];
            foreach (explode(',', $start->get_qt_var('_stemorder')) as $key => $stem) {
                $place = array_search($stem, array_keys($question->stems));
                $option = $answer['options'][$place] ?? null;
                $choice = array_search(array_search($option, $question->choices), $shown);
                $data["sub$key"] = $option === null ? 0 : $choice + 1;
            }
            return $data;
        default:
            $data = [];
            foreach (explode(',', $start->get_qt_var('_order')) as $key => $id) {
                if (in_array(array_search($id, array_keys($question->answers)), $answer['chosen'])) {
                    $data += $question instanceof qtype_multichoice_multi_question ? ["choice$key" => 1] : ['answer' => $key];
                }
            }
            return $data;
    }
}

// Install a language with a decimal comma if this copy of Moodle has none.
function ensure_language(string $name): void {
    global $CFG;
    $file = "{$CFG->dataroot}/lang/$name/langconfig.php";
    if ($name !== 'en' && !file_exists($file)) {
        make_writable_directory(dirname($file));
        file_put_contents($file, "<?php\n\$string['decsep'] = ',';\n\$string['thousandssep'] = '.';\n");
        get_string_manager()->reset_caches();
    }
}

// Answer a question in a language; return the fraction earned, and its page before and after.
function answer_question(int $id, array $answer, context $context): array {
    ensure_language($answer['language']);
    force_current_language($answer['language']);
    $usage = question_engine::make_questions_usage_by_activity('core_question_preview', $context);
    $usage->set_preferred_behaviour('deferredfeedback');
    $slot = $usage->add_question(question_bank::load_question($id), 1);
    $usage->start_question($slot);
    $options = new question_display_options();
    $blank = $usage->render_question($slot, $options, '1');
    $usage->process_action($slot, make_form_data($usage->get_question_attempt($slot), $answer));
    $usage->finish_question($slot);
    $shown = $usage->render_question($slot, $options, '1');
    return ['fraction' => $usage->get_question_fraction($slot), 'state' => (string) $usage->get_question_state($slot),
        'blank' => $blank, 'shown' => $shown];
}

// Enrol students and import their marks; return the marks in the gradebook by email address.
function import_marks(string $file, stdClass $course, array $students): array {
    global $DB;
    foreach ($students as $student) {
        $user = $DB->get_record('user', ['email' => $student['email']]);
        $fields = ['username' => $student['id'] . uniqid(), 'auth' => 'manual', 'confirmed' => 1, 'mnethostid' => 1];
        $names = ['firstname' => $student['name'], 'lastname' => '-', 'email' => $student['email']];
        $id = $user ? $user->id : user_create_user($fields + $names, false, false);
        enrol_try_internal_enrol($course->id, $id, 5);
    }
    $import = new gradeimport_csv_load_data();
    $import->load_csv_content(file_get_contents($file), 'UTF-8', 'comma', 10);
    $reader = new csv_import_reader($import->get_iid(), 'grade');
    $header = $reader->get_columns();
    $code = get_new_importcode();
    $mail = array_search('Email address', $header);
    $points = array_search('percent', array_map(fn($name) => str_contains($name, 'percent') ? 'percent' : '', $header));
    $form = ['id' => $course->id, 'iid' => $import->get_iid(), 'importcode' => $code, 'forceimport' => true];
    $form += ['mapfrom' => $mail, 'mapto' => 'useremail'];
    $form += array_fill_keys(array_map(fn($index) => "mapping_$index", array_keys($header)), '0');
    // Import into an existing item, as our docs recommend: for a "new" item, Moodle takes the maximum from any item, of any
    // course, that happens to have the number of the import.
    $item = ['courseid' => $course->id, 'itemtype' => 'manual', 'itemname' => 'Homework', 'grademin' => 0, 'grademax' => 100];
    $form["mapping_$points"] = (string) (new grade_item($item, false))->insert();
    $done = $import->prepare_import_grade_data($header, (object) $form, $reader, $course->id, false, 0, false);
    if (!$done) {
        return ['done' => false, 'messages' => $import->get_gradebookerrors()];
    }
    ob_start();
    grade_import_commit($course->id, $code);
    ob_end_clean();
    $sql = 'SELECT u.email, g.finalgrade FROM {grade_grades} g JOIN {user} u ON u.id = g.userid
              JOIN {grade_items} i ON i.id = g.itemid WHERE i.courseid = ? AND i.itemtype = ?';
    return ['done' => true, 'messages' => [], 'grades' => $DB->get_records_sql_menu($sql, [$course->id, 'manual'])];
}

\core\session\manager::set_user(get_admin());
$course = create_test_course();
$context = context_course::instance($course->id);
$PAGE->set_context($context);
$PAGE->set_course($course);
$PAGE->set_url('/');
$response = ['software' => 'Moodle ' . $CFG->release];
foreach (['xml', 'quiz'] as $kind) {
    if ($request[$kind] ?? null) {
        if ($kind === 'xml') {
            $bank = get_bank_context($course);
            $imported = import($request['xml'], $course, $bank) + ['questions' => load_questions($bank), 'context' => $bank];
        } else {
            $imported = restore_quiz($request['quiz'], $course);
            $imported += $imported['done'] ? ['questions' => load_questions($imported['context'])] : [];
        }
        $question_context = $imported['context'] ?? $context;
        unset($imported['context']);
        foreach ($imported['done'] ? $request['answers'] : [] as $name => $answers) {
            $id = (int) ($imported['questions'][$name]['id'] ?? 0);
            $imported['answers'][$name] = $id ? array_map(fn($answer) => answer_question($id, $answer, $question_context), $answers) : [];
        }
        force_current_language('');
        $response[$kind] = $imported;
    }
}
if ($request['gradebook'] ?? null) {
    $response['gradebook'] = import_marks($request['gradebook'], $course, $request['students']);
}
echo json_encode($response, JSON_THROW_ON_ERROR);
