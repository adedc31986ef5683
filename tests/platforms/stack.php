<?php
// Import our questions into Moodle with STACK, show them, and run their tests: `php stack.php < request.json`, called by
// stack.py.
//
// The request: `config` (path of Moodle's config.php), `xml` and `quiz`, the files to import and to restore, `patience`, the
// seconds that a call of Maxima may take, and `typed`: by the name of a question, answers to type, each a text or the rows of
// a matrix. The output is lines of JSON: one about the software and the import, then one for each question with its stored
// fields, its page before and after an attempt, the mark of a blank attempt, the results of its tests, and those of the typed
// answers; then the same for the quiz, whose questions run only their first test.

require(__DIR__ . '/import.php');
$config = get_config('qtype_stack');
$stack_settings = ['castimeout' => $request['patience']];
foreach (['maximacommand', 'maximacommandopt'] as $name) {
    $stack_settings[$name] = preg_replace('/^timeout --kill-after=\d+s \d+s/', "timeout {$request['patience']}s", $config->$name ?? '');
}
$CFG->forced_plugin_settings['qtype_stack'] = array_filter($stack_settings);
require_once($CFG->dirroot . '/question/type/stack/locallib.php');
require_once($CFG->dirroot . '/question/type/stack/stack/questiontest.php');

function print_line(array $line): void {
    echo "\n" . json_encode($line, JSON_THROW_ON_ERROR) . "\n";
}

// Return the STACK questions of a context in the order of the import.
function load_questions(context $context): array {
    global $DB;
    $sql = "SELECT q.id, q.name, e.idnumber, q.defaultmark, c.name AS category
              FROM {question} q
              JOIN {question_versions} v ON v.questionid = q.id
              JOIN {question_bank_entries} e ON e.id = v.questionbankentryid
              JOIN {question_categories} c ON c.id = e.questioncategoryid
             WHERE c.contextid = ? AND q.qtype = 'stack' ORDER BY q.id";
    return array_values($DB->get_records_sql($sql, [$context->id]));
}

// Return the processor time in seconds of PHP and of all Maxima processes that have ended.
function measure_processor_time(): float {
    $seconds = 0.0;
    foreach ([0, 1] as $who) {
        $used = getrusage($who);
        foreach (['utime', 'stime'] as $kind) {
            $seconds += $used["ru_$kind.tv_sec"] + $used["ru_$kind.tv_usec"] / 1e6;
        }
    }
    return $seconds;
}

// Run a question test; return whether it passed, why not, the expected score, and the elapsed and processor times.
function run_test(stack_question_test $test, int $id, context $context): array {
    [$start, $used] = [microtime(true), measure_processor_time()];
    $result = $test->test_question($id, null, $context);
    [$seconds, $used] = [microtime(true) - $start, measure_processor_time() - $used];
    $outcome = $result->passed_with_reasons();
    $expected = $test->expectedresults['prt1'];
    return [
        'description' => $test->description, 'passed' => (bool) $outcome['passed'], 'expected' => $expected->score, 'seconds' => $seconds,
        'processor_seconds' => $used, 'reason' => trim(strip_tags($outcome['reason'] ?? '')),
    ];
}

// Show a question, finish a blank attempt, and show it again; return both pages, the fraction earned, and any errors.
function show_question(int $id, context $context): array {
    $usage = question_engine::make_questions_usage_by_activity('core_question_preview', $context);
    $usage->set_preferred_behaviour('deferredfeedback');
    $question = question_bank::load_question($id);
    $slot = $usage->add_question($question, $question->defaultmark);
    $start = microtime(true);
    $usage->start_question($slot);
    $options = new question_display_options();
    $page = $usage->render_question($slot, $options, '1');
    $seconds = microtime(true) - $start;
    $usage->finish_question($slot);
    $options->generalfeedback = question_display_options::VISIBLE;
    $after = $usage->render_question($slot, $options, '1');
    $errors = array_keys($question->runtimeerrors ?? []);
    $blank = (float) $usage->get_question_fraction($slot);
    return ['page' => $page, 'after' => $after, 'blank' => $blank, 'seconds' => $seconds, 'errors' => $errors];
}

// Type an answer, a text or the rows of a matrix, as a student does, and confirm how STACK parsed it. Return the state of the
// input, what STACK says about an invalid answer, and the score and answer notes (null if STACK marks nothing).
function type_answer(int $id, string|array $typed, context $context): array {
    $usage = question_engine::make_questions_usage_by_activity('core_question_preview', $context);
    $usage->set_preferred_behaviour('adaptive');
    $slot = $usage->add_question(question_bank::load_question($id), 1);
    $usage->start_question($slot);
    $question = $usage->get_question($slot);
    $form = is_array($typed) ? [] : ['ans1' => $typed];
    foreach (is_array($typed) ? $typed : [] as $row => $cells) {
        foreach ($cells as $column => $cell) {
            $form["ans1_sub_{$row}_$column"] = $cell;
        }
    }
    $input = $question->inputs['ans1'];
    $form['ans1_val'] = $input->contents_to_maxima($question->get_input_state('ans1', $form)->contents);
    $state = $question->get_input_state('ans1', $form);
    $result = $question->get_prt_result('prt1', $form, true);
    $score = $state->status === stack_input::SCORE ? $result->get_score() : null;
    return ['typed' => $typed, 'status' => $state->status, 'errors' => trim(strip_tags($state->errors)), 'score' => $score,
        'notes' => $result->get_answernotes()];
}

\core\session\manager::set_user(get_admin());
core_php_time_limit::raise(0);
$course = create_test_course();
$context = context_course::instance($course->id);
$PAGE->set_context($context);
$PAGE->set_course($course);
$PAGE->set_url('/');
$plugin = core_plugin_manager::instance()->get_plugin_info('qtype_stack')->release;
$info = ['moodle' => $CFG->release, 'stack' => $plugin, 'database' => $DB->get_name(), 'platform' => $config->platform];
$bank = get_bank_context($course);
print_line($info + ['import' => import($request['xml'], $course, $bank)]);
foreach (load_questions($bank) as $question) {
    $tests = question_bank::get_qtype('stack')->load_question_tests($question->id);
    $answers = $request['typed'][$question->name] ?? [];
    print_line((array) $question + show_question($question->id, $context) + [
        'place' => 'bank', 'test_count' => count($tests),
        'tests' => array_values(array_map(fn($test) => run_test($test, $question->id, $context), $tests)),
        'typed' => array_map(fn($typed) => type_answer($question->id, $typed, $context), $answers),
    ]);
}
if ($request['quiz'] ?? null) {
    $restored = restore_quiz($request['quiz'], create_test_course());
    $questions = $restored['done'] ? load_questions($restored['context']) : [];
    unset($restored['context']);
    print_line(['quiz' => $restored]);
    foreach ($questions as $question) {
        $tests = question_bank::get_qtype('stack')->load_question_tests($question->id);
        print_line((array) $question + show_question($question->id, $context) + [
            'place' => 'quiz', 'test_count' => count($tests),
            'tests' => [run_test(reset($tests), $question->id, $context)],
        ]);
    }
}
