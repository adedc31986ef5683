<?php
// What Moodle with STACK makes of our questions: `php stack.php < request.json`, which answers in lines of JSON; asked by
// stack.py.
//
// The request: `config` (Moodle's config.php), `xml`, the file to import, and `patience`, the seconds that a call of
// Maxima may take by the clock of this run. The answer: a line on the software and the
// import, then a line for each question: what is stored of it, what its page shows, what a blank attempt earns, and of
// each question test whether STACK passes it, the score that was expected, the seconds that it took, and those of
// the processor, and why it did not.

require(__DIR__ . '/import.php');
$config = get_config('qtype_stack');
$patient = ['castimeout' => $request['patience']];
foreach (['maximacommand', 'maximacommandopt'] as $name) {
    $patient[$name] = preg_replace('/^timeout --kill-after=\d+s \d+s/', "timeout {$request['patience']}s", $config->$name ?? '');
}
$CFG->forced_plugin_settings['qtype_stack'] = array_filter($patient);
require_once($CFG->dirroot . '/question/type/stack/locallib.php');
require_once($CFG->dirroot . '/question/type/stack/stack/questiontest.php');

function told(array $line): void {
    echo "\n" . json_encode($line, JSON_THROW_ON_ERROR) . "\n";
}

function questions_of(context $context): array {
    global $DB;
    $sql = "SELECT q.id, q.name, e.idnumber, q.defaultmark, c.name AS category
              FROM {question} q
              JOIN {question_versions} v ON v.questionid = q.id
              JOIN {question_bank_entries} e ON e.id = v.questionbankentryid
              JOIN {question_categories} c ON c.id = e.questioncategoryid
             WHERE c.contextid = ? AND q.qtype = 'stack' ORDER BY q.id";
    return array_values($DB->get_records_sql($sql, [$context->id]));
}

// Seconds of processor time, of PHP and of all Maximas that have ended.
function processor(): float {
    $seconds = 0.0;
    foreach ([0, 1] as $who) {
        $used = getrusage($who);
        foreach (['utime', 'stime'] as $kind) {
            $seconds += $used["ru_$kind.tv_sec"] + $used["ru_$kind.tv_usec"] / 1e6;
        }
    }
    return $seconds;
}

function tested(stack_question_test $test, int $id, context $context): array {
    [$start, $used] = [microtime(true), processor()];
    $result = $test->test_question($id, null, $context);
    [$seconds, $used] = [microtime(true) - $start, processor() - $used];
    $said = $result->passed_with_reasons();
    $due = $test->expectedresults['prt1'];
    return [
        'about' => $test->description, 'passed' => (bool) $said['passed'], 'due' => $due->score, 'seconds' => $seconds,
        'used' => $used, 'why' => trim(strip_tags($said['reason'] ?? '')),
    ];
}

function shown(int $id, context $context): array {
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

\core\session\manager::set_user(get_admin());
core_php_time_limit::raise(0);
$course = a_course();
$context = context_course::instance($course->id);
$PAGE->set_context($context);
$PAGE->set_course($course);
$PAGE->set_url('/');
$plugin = core_plugin_manager::instance()->get_plugin_info('qtype_stack')->release;
$about = ['moodle' => $CFG->release, 'stack' => $plugin, 'database' => $DB->get_name(), 'platform' => $config->platform];
told($about + ['import' => import($request['xml'], $course, bank_context($course))]);
foreach (questions_of($context) as $question) {
    $tests = question_bank::get_qtype('stack')->load_question_tests($question->id);
    told((array) $question + shown($question->id, $context) + [
        'tests' => array_values(array_map(fn($test) => tested($test, $question->id, $context), $tests)),
    ]);
}
