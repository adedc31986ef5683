<?php
/*
 * Load the items and the test of a QTI 2.1 package, validate them, and score responses. The first argument is the folder
 * of the engine, the second the package. Standard input is a JSON list of items with the responses to each attempt,
 * [item, [{variable: value}]]; standard output has the results as JSON: `items` and `tests`.
 */

require $argv[1] . '/vendor/autoload.php';

use qtism\common\datatypes\files\FileSystemFileManager;
use qtism\common\datatypes\QtiDirectedPair;
use qtism\common\datatypes\QtiFloat;
use qtism\common\datatypes\QtiIdentifier;
use qtism\common\enums\BaseType;
use qtism\common\enums\Cardinality;
use qtism\data\storage\xml\XmlCompactDocument;
use qtism\data\storage\xml\XmlDocument;
use qtism\runtime\common\MultipleContainer;
use qtism\runtime\common\ResponseVariable;
use qtism\runtime\common\State;
use qtism\runtime\rendering\markup\xhtml\XhtmlRenderingEngine;
use qtism\runtime\tests\AssessmentItemSession;
use qtism\runtime\tests\SessionManager;

function load_document(string $path): XmlDocument
{
    $document = new XmlDocument();
    $document->load($path, true);

    return $document;
}

/** Return a response variable of the declared type: a number, an identifier, or several identifiers or pairs. */
function make_response($declared, $response): ResponseVariable
{
    $convert = match ($declared->getBaseType()) {
        BaseType::FLOAT => fn ($value) => new QtiFloat((float) $value),
        BaseType::IDENTIFIER => fn ($value) => new QtiIdentifier($value),
        BaseType::DIRECTED_PAIR => fn ($value) => new QtiDirectedPair(...explode(' ', $value)),
    };
    $value = $declared->getCardinality() === Cardinality::MULTIPLE
        ? new MultipleContainer($declared->getBaseType(), array_map($convert, $response))
        : ($response === null ? null : $convert($response));
    $variable = ResponseVariable::createFromDataModel($declared);
    $variable->setValue($value);

    return $variable;
}

/** Make another attempt at an item; return its score and the identifiers of the feedback shown. */
function attempt(AssessmentItemSession $session, array $responses): array
{
    $session->beginAttempt();
    $state = new State();
    foreach ($session->getAssessmentItem()->getResponseDeclarations() as $declared) {
        if (array_key_exists($declared->getIdentifier(), $responses)) {
            $state->setVariable(make_response($declared, $responses[$declared->getIdentifier()]));
        }
    }
    $session->endAttempt($state);
    $feedback = [];
    foreach ($session['FEEDBACK'] ?? [] as $identifier) {
        $feedback[] = $identifier->getValue();
    }

    return ['score' => $session['SCORE']->getValue(), 'feedback' => $feedback];
}

/** Render an item and make all attempts at it; return the page and the results, or the error. */
function attempt_item(string $package, array $request): array
{
    [$item, $attempts] = $request;
    try {
        $loaded = load_document("$package/items/$item.xml")->getDocumentComponent();
        $session = new AssessmentItemSession($loaded);
        $session->getItemSessionControl()->setMaxAttempts(0);
        $session->beginItemSession();
        $page = (new XhtmlRenderingEngine())->render($loaded)->saveXML();

        return ['page' => $page, 'attempts' => array_map(fn ($responses) => attempt($session, $responses), $attempts)];
    } catch (Throwable $error) {
        return ['error' => get_class($error) . ': ' . $error->getMessage()];
    }
}

/** Begin the test; return the selected items in order, and the number of attempts allowed at the first. */
function select_items(string $package): array
{
    $test = XmlCompactDocument::createFromXmlAssessmentTestDocument(load_document("$package/test.xml"));
    $manager = new SessionManager(new FileSystemFileManager());
    $session = $manager->createAssessmentTestSession($test->getDocumentComponent());
    $session->beginTestSession();
    $items = [];
    foreach ($session->getRoute()->getAllRouteItems() as $route_item) {
        $items[] = $route_item->getAssessmentItemRef()->getIdentifier();
    }

    return ['items' => $items, 'attempts' => $session->getCurrentRemainingAttempts()];
}

$requests = json_decode(stream_get_contents(STDIN), true);
$scored = array_map(fn ($request) => attempt_item($argv[2], $request), $requests);
try {
    $tests = [select_items($argv[2]), select_items($argv[2])];
} catch (Throwable $error) {
    $tests = ['error' => get_class($error) . ': ' . $error->getMessage()];
}
echo json_encode(['items' => $scored, 'tests' => $tests]);
