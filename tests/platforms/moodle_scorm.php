<?php
// Make a course in Moodle with students and with SCORM packages as activities, or return the marks of such a course. The
// request is JSON on standard input: `config` is the path of Moodle's config.php, `packages` are files by name, and
// `students` their names; or `course` is the id of a course made before.

require(__DIR__ . '/import.php');
require_once($CFG->dirroot . '/course/modlib.php');
require_once($CFG->dirroot . '/mod/scorm/lib.php');
require_once($CFG->dirroot . '/user/lib.php');
require_once($CFG->libdir . '/gradelib.php');

// Add a SCORM activity as a teacher does who uploads a package and keeps all default settings of the site.
function add_scorm_activity(stdClass $course, string $name, string $file): array {
    global $DB, $USER;
    $draft = file_get_unused_draft_itemid();
    $file_record = ['contextid' => context_user::instance($USER->id)->id, 'component' => 'user', 'filearea' => 'draft',
        'itemid' => $draft, 'filepath' => '/', 'filename' => basename($file)];
    get_file_storage()->create_file_from_pathname($file_record, $file);
    $defaults = get_config('scorm');
    $form = (object) ['modulename' => 'scorm', 'name' => $name, 'introeditor' => ['text' => '', 'format' => 1, 'itemid' => 0],
        'section' => 0, 'visible' => 1, 'course' => $course->id, 'scormtype' => SCORM_TYPE_LOCAL, 'packagefile' => $draft,
        'cmidnumber' => '', 'groupmode' => 0, 'groupingid' => 0, 'completion' => 0, 'timeopen' => 0, 'timeclose' => 0,
        'module' => $DB->get_field('modules', 'id', ['name' => 'scorm'], MUST_EXIST)];
    foreach (['popup', 'width', 'height', 'skipview', 'hidebrowse', 'displaycoursestructure', 'hidetoc', 'nav', 'navpositionleft',
        'navpositiontop', 'displayattemptstatus', 'grademethod', 'maxgrade', 'maxattempt', 'whatgrade', 'forcecompleted',
        'forcenewattempt', 'lastattemptlock', 'masteryoverride', 'auto', 'updatefreq'] as $key) {
        $form->$key = $defaults->$key ?? 0;
    }
    $added = add_moduleinfo($form, $course);
    $scorm = $DB->get_record('scorm', ['id' => $added->instance], '*', MUST_EXIST);
    $units = $DB->get_records('scorm_scoes', ['scorm' => $scorm->id, 'scormtype' => 'sco']);
    return ['activity' => $added->coursemodule, 'scorm' => $scorm->id, 'version' => $scorm->version, 'units' => count($units),
        'unit' => $units ? reset($units)->id : 0, 'highest' => $scorm->maxgrade];
}

\core\session\manager::set_user(get_admin());
$answer = ['software' => 'Moodle ' . $CFG->release, 'root' => $CFG->wwwroot];
if ($request['packages'] ?? null) {
    $course = create_test_course();
    $answer['course'] = $course->id;
    foreach ($request['students'] as $name) {
        $user = ['username' => $name . uniqid(), 'password' => 'Qdot-1-velocity!', 'auth' => 'manual', 'confirmed' => 1,
            'mnethostid' => $CFG->mnet_localhost_id, 'firstname' => ucfirst($name), 'lastname' => '-',
            'email' => uniqid() . '@example.org', 'idnumber' => $name];
        enrol_try_internal_enrol($course->id, user_create_user($user, true, false), 5);
        $answer['students'][$name] = ['username' => $user['username'], 'password' => $user['password']];
    }
    foreach ($request['packages'] as $name => $file) {
        $answer['activities'][$name] = add_scorm_activity($course, $name, $file);
    }
} else {
    $sql = 'SELECT ' . $DB->sql_concat('i.itemname', "' '", 'u.idnumber') . ', g.finalgrade
              FROM {grade_grades} g JOIN {user} u ON u.id = g.userid JOIN {grade_items} i ON i.id = g.itemid
             WHERE i.courseid = ? AND i.itemmodule = ?';
    $answer['marks'] = $DB->get_records_sql_menu($sql, [$request['course'], 'scorm']);
}
echo json_encode($answer);
